"""A load set as one HTML page that needs no other file and no network."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path

from turbine_fenicsx.load_sets import set_panels
from turbine_fenicsx.load_sets.extrapolation import CONFIDENCE
from turbine_fenicsx.load_sets.lifetime import LIFE
from turbine_fenicsx.load_sets.load_set import ALL
from turbine_fenicsx.load_sets.spectra import find_spectra
from turbine_fenicsx.load_sets.stored_set import StoredSet, WindTable, read_winds
from turbine_fenicsx.postprocessing.life_page import format_life
from turbine_fenicsx.postprocessing.page import (
    embed_figure,
    fill_page,
    format_grid,
    format_note,
)
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.output_folder import SET, read_tables
from turbine_fenicsx.records.steady_tables import WIND

UNITS = {"Nm": ("MN m", 1e-6), "N": ("kN", 1e-3), "m": ("m", 1.0)}
"""Units of the loads and deflections in the table of extremes, and those that are shown."""

SPECTRA = 3
"""Maximum number of wind speeds whose spectra are drawn."""


def report_set(
    folder: str | os.PathLike[str], beside: Sequence[str | os.PathLike[str]] = ()
) -> str:
    """Describe a load set.

    Args:
        beside: Tables of other sets or codes, as `read_winds` reads, drawn over the wind speed.

    Raises:
        InputError: for a folder without a set, or tables that are damaged.
    """
    found = StoredSet.read(folder)
    others = {Path(path).stem: read_winds(Path(path)) for path in beside}
    states = Counter(row["state"] for row in found.runs)
    sections = {
        "Runs": _list_runs(found),
        "Over the wind speed": _draw_over_wind(found, others),
        "Extremes": _list_extremes(found),
        "Return periods": _draw_returns(found),
        "Life": _draw_life(found),
        "Life of the plies": format_life(found.folder),
        "Spectra": _draw_spectra(found),
    }
    counts = ", ".join(f"{number} {state}" for state, number in states.items())
    return fill_page(f"Load set {found.folder.resolve().name}", f"runs: {counts}", sections)


def _list_runs(found: StoredSet) -> str:
    """Runs of each situation, and why some failed."""
    groups: dict[str, list[Mapping[str, str]]] = {}
    for row in found.runs:
        groups.setdefault(row["situation"], []).append(row)
    lines = [
        (name, len(rows), sum(row["state"] == "finished" for row in rows), _list_speeds(rows))
        for name, rows in groups.items()
    ]
    table = format_grid(("situation", "runs", "finished", "wind speeds [m/s]"), lines)
    failed = [(row["run"], row["reason"]) for row in found.runs if row["state"] == "failed"]
    return table + (format_grid(("failed run", "reason"), failed) if failed else "")


def _list_speeds(rows: Sequence[Mapping[str, str]]) -> str:
    """Wind speeds of runs in words."""
    return ", ".join(f"{x:g}" for x in sorted({float(row[WIND]) for row in rows}))


def _draw(draw: Callable[[Path], None], caption: str) -> str:
    """A figure, or a note if it cannot be drawn here."""
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "figure.png"
        try:
            draw(path)
        except ImportError as error:
            return format_note(f"There are no diagrams: {error}.")
        return embed_figure(path, caption)


def _draw_over_wind(
    found: StoredSet, others: Mapping[str, Mapping[str, Mapping[str, WindTable]]]
) -> str:
    """Channels over the wind speed, of situations with several."""
    texts = []
    for name, channels in found.winds.items():
        shown = {c: table for c, table in channels.items() if c in set_panels.SHOWN}
        if not shown or max(len(table.speeds) for table in shown.values()) < 2:
            continue
        # tables of others have situations of the same names, or none
        own = {label: {**x.get("", {}), **x.get(name, {})} for label, x in others.items()}
        beside = f"; lines: {', '.join(own)} with deviation" if own else ""
        texts.append(
            _draw(
                partial(set_panels.draw_winds, shown, own),
                f"Situation {name}: means with deviations, and between means of the least and of "
                f"the largest values of the runs{beside}.",
            )
        )
    return "".join(texts)


def _list_extremes(found: StoredSet) -> str:
    """Extremes of loads over all situations with the runs that had them."""
    head = ("load", "least", "situation and run", "largest", "situation and run")
    situations: dict[tuple[str, str, str], str] = {}
    for row in found.extremes:
        for side in ("least", "largest"):
            key = row["column"], row[f"factored_{side}"], side
            if row["situation"] != ALL:
                situations.setdefault(key, row["situation"])
    lines = []
    for row in found.extremes:
        name, unit = split_unit(row["column"])
        if row["situation"] != ALL or unit not in UNITS:
            continue
        shown, scale = UNITS[unit]
        line = [f"{name.replace('_', ' ')} [{shown}]"]
        for side in ("least", "largest"):
            value = row[f"factored_{side}"]
            situation = situations[row["column"], value, side]
            line += [f"{scale * float(value):.4g}", _name_run(row, side, situation)]
        lines.append(line)
    if not lines:
        return ""
    return (
        "<p>Values times safety factors, over all situations; "
        f"{escape(SET)} has all channels of each.</p>\n{format_grid(head, lines)}"
    )


def _name_run(row: Mapping[str, str], side: str, situation: str) -> str:
    """The run of an extreme, and when it was."""
    run, time = row[f"run_of_{side}"], row[f"time_of_{side}_[s]"]
    return f"{run} at {float(time):g} s" if time else f"{situation}, {run}"


def _draw_returns(found: StoredSet) -> str:
    """Loads over the return period, of each situation that has some."""
    texts = []
    for name in dict.fromkeys(row["situation"] for row in found.returns):
        own = [row for row in found.returns if row["situation"] == name]
        if any(row["column"] in set_panels.EXTREME for row in own):
            texts.append(
                _draw(
                    partial(set_panels.draw_exceedance, own),
                    f"Situation {name}: loads over their return period without safety factors, by "
                    f"Gumbel's distribution of extremes at each wind speed, with limits of "
                    f"{CONFIDENCE:.0%} confidence.",
                )
            )
    return "".join(texts)


def _draw_life(found: StoredSet) -> str:
    """Equivalent loads of the life."""
    if not any(row["run"] == LIFE for row in found.fatigue):
        return ""
    return _draw(
        partial(set_panels.draw_life, found.fatigue),
        "Ranges that do the damage of the life in its equivalent cycles.",
    )


def _draw_spectra(found: StoredSet) -> str:
    """Spectra of the first turbulent situation, at few wind speeds."""
    done = [row for row in found.runs if row["state"] == "finished" and row.get("seed")]
    if not done:
        return ""
    own = [row for row in done if row["situation"] == done[0]["situation"]]
    speeds = sorted({float(row[WIND]) for row in own})
    n = len(speeds)
    chosen = sorted({speeds[k * (n - 1) // max(SPECTRA - 1, 1)] for k in range(min(n, SPECTRA))})
    runs = {v: [row["run"] for row in own if float(row[WIND]) == v] for v in chosen}
    case = read_tables(found.folder / own[0]["run"] / "case.json")
    begin = float((case or {}).get("output", {}).get("transient", 0.0))
    spectra = find_spectra(found.folder, runs, begin)
    if not spectra:
        return format_note("There are no spectra: the folders of the runs are not here.")
    return _draw(
        partial(set_panels.draw_spectra, spectra),
        f"Situation {own[0]['situation']}: power spectral densities, means over the runs of a wind "
        "speed (Welch).",
    )
