"""Tables of a load set: its runs, and means and extremes of all channels over each situation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import degrees, sqrt
from pathlib import Path
from typing import Any

from turbine_fenicsx.load_sets.load_set import ALL, LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.load_sets.return_loads import ReturnLoad
from turbine_fenicsx.load_sets.situation import Situation
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import format_rows
from turbine_fenicsx.records.output_folder import read_tables
from turbine_fenicsx.records.statistics import ColumnStatistics
from turbine_fenicsx.records.steady_tables import WIND

Results = Mapping[str, Sequence[ColumnStatistics]]
"""Statistics of finished runs by name."""


BEGIN, TIMES, YEARS = "begin_[s]", "times_in_life", names.LIFE
"""Columns of ``runs.csv``: time before which nothing counts, how often a run happens in the life,
and how long that is."""

EXTRAPOLATED = "extrapolated"
"""In place of the run of extremes that no run had."""


def format_runs(
    load_set: LoadSet,
    runs: Sequence[SetRun],
    results: Results,
    failed: Mapping[str, str],
    times: Mapping[str, float],
    out: Path,
) -> str:
    """``runs.csv``: what each run is, how it went, with which step and ramp.

    Args:
        times: How often runs that count for fatigue happen in the life.
    """
    chosen = load_set.chosen
    rows: list[dict[str, float | str]] = []
    for each in runs:
        name = each.run.name
        state = "finished" if name in results else "failed" if name in failed else "not run"
        rows.append(
            {
                "run": name,
                "situation": each.situation,
                WIND: each.wind,
                "yaw_error_[deg]": round(degrees(each.yaw_error), 9),
                "variant": each.variant,
                "seed": "" if each.seed is None else each.seed,
                "state": state,
                **_read_tries(out / name, state == "finished"),
                BEGIN: chosen[each.situation].transient,
                TIMES: times.get(name, 0.0),
                YEARS: load_set.lifetime.years,
                "reason": failed.get(name, ""),
            }
        )
    return format_rows(rows)


def _read_tries(folder: Path, finished: bool) -> dict[str, Any]:
    """Keys that a second try changes, as a finished run has them [s]."""
    if not finished:
        return {"step_[s]": "", "ramp_[s]": ""}
    tables: Any = read_tables(folder / "case.json")
    ramp = tables.get("wind", {}).get("ramp", 0.0)
    return {"step_[s]": float(tables["time"]["step"]), "ramp_[s]": float(ramp)}


def format_extremes(
    runs: Sequence[SetRun],
    situations: Mapping[str, Situation],
    results: Results,
    extrapolated: Mapping[str, Iterable[ReturnLoad]],
) -> str:
    """``set.csv``: a row for each channel in each situation, and in all of them.

    Empty before the first run is finished.

    Args:
        extrapolated: Loads of the return period of the set, by situation; these alone are the
            extremes of situations that evaluate extrapolation.
    """
    rows: list[dict[str, Any]] = []
    for name, situation in situations.items():
        source = situation.uses or name
        members = [each.run.name for each in runs if each.situation == source]
        done = {run: results[run] for run in members if run in results}
        own = _summarise(name, situation.factor, done)
        if situation.evaluates == "extrapolation":
            own = _put_extrapolated(own, extrapolated.get(name, ()), situation.factor)
        rows += own
    if not rows:
        return ""
    channels = dict.fromkeys(row["column"] for row in rows)
    by_channel: dict[str, list[dict[str, Any]]] = {channel: [] for channel in channels}
    for row in rows:
        by_channel[row["column"]].append(row)
    return format_rows([*rows, *map(_find_worst, by_channel.values())])


def _summarise(situation: str, factor: float, done: Results) -> list[dict[str, Any]]:
    """Rows of a situation, over its finished runs."""
    columns: dict[str, dict[str, ColumnStatistics]] = {}
    for run, found in done.items():
        for each in found:
            columns.setdefault(each.column, {})[run] = each
    rows = []
    for column, by_run in columns.items():
        least = min(by_run, key=lambda run: by_run[run].least)
        largest = max(by_run, key=lambda run: by_run[run].largest)
        low, high = by_run[least], by_run[largest]
        rows.append(
            {
                "situation": situation,
                "column": column,
                **_find_means(list(by_run.values())),
                "least": low.least,
                "run_of_least": least,
                "time_of_least_[s]": low.time_of_least,
                "largest": high.largest,
                "run_of_largest": largest,
                "time_of_largest_[s]": high.time_of_largest,
                "safety_factor": factor,
                "factored_least": factor * low.least,
                "factored_largest": factor * high.largest,
            }
        )
    return rows


def _find_means(found: Sequence[ColumnStatistics]) -> dict[str, float]:
    """Mean and deviation of a channel over runs."""
    n = len(found)
    return {
        "runs": n,
        "mean": sum(x.mean for x in found) / n,
        "deviation": sqrt(sum(x.deviation**2 for x in found) / n),
    }


def format_winds(runs: Sequence[SetRun], results: Results) -> str:
    """``winds.csv``: a row for each channel in each situation at each of its wind speeds.

    Least and largest values are means over the runs of those of each.
    """
    groups: dict[tuple[str, str, float], list[ColumnStatistics]] = {}
    for each in runs:
        for found in results.get(each.run.name, ()):
            groups.setdefault((each.situation, found.column, each.wind), []).append(found)
    rows: list[dict[str, float | str]] = [
        {
            "situation": situation,
            "column": column,
            WIND: wind,
            **_find_means(found),
            "least": sum(x.least for x in found) / len(found),
            "largest": sum(x.largest for x in found) / len(found),
        }
        for (situation, column, wind), found in sorted(groups.items(), key=lambda item: item[0])
    ]
    return format_rows(rows) if rows else ""


def _put_extrapolated(
    rows: Sequence[dict[str, Any]], loads: Iterable[ReturnLoad], factor: float
) -> list[dict[str, Any]]:
    """Rows with extrapolated extremes, of columns that have both."""
    found: dict[str, dict[str, Any]] = {}
    for load in loads:
        found.setdefault(load.column, {}).update(
            {
                load.side: load.value,
                f"run_of_{load.side}": EXTRAPOLATED,
                f"time_of_{load.side}_[s]": "",
                f"factored_{load.side}": factor * load.value,
            }
        )
    whole = {c: own for c, own in found.items() if {"least", "largest"} <= own.keys()}
    return [{**row, **whole[row["column"]]} for row in rows if row["column"] in whole]


def _find_worst(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The row of a channel over all situations; extremes are those of loads with factors."""
    least = min(rows, key=lambda row: float(row["factored_least"]))
    largest = max(rows, key=lambda row: float(row["factored_largest"]))
    low = {key: value for key, value in least.items() if "least" in key}
    high = {key: value for key, value in largest.items() if "largest" in key}
    blank = {"mean": "", "deviation": "", "safety_factor": ""}
    runs = sum(int(row["runs"]) for row in rows)
    return {**rows[0], **blank, "situation": ALL, "runs": runs, **low, **high}
