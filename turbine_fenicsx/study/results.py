"""Results of the runs of a study, and their table."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import read_regular
from turbine_fenicsx.foundation.text_files import suggest
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import INTERRUPTED, TIME, split_unit
from turbine_fenicsx.records.output_folder import holds_run
from turbine_fenicsx.study.file import flatten
from turbine_fenicsx.study.plan import Run

RESULTS = ("history.csv", "summary.json")
"""The files that a finished run has, as far as a study reads them."""

NOTHING = 1e-9
"""Smaller means count as zero, in SI units and as a part of the largest value of a run."""


def is_finished(run: Run, folder: Path) -> bool:
    """Whether a folder holds the results of just this run, to its end."""
    return _end_of(run, folder) == "end"


def is_interrupted(run: Run, folder: Path) -> bool:
    """Whether a folder holds just this run, which was interrupted and can resume."""
    return _end_of(run, folder) == "interrupted"


def is_other(run: Run, folder: Path) -> bool:
    """Whether a folder holds results, but of another run."""
    return holds_run(folder) and not _is_same(run, folder)


def _is_same(run: Run, folder: Path) -> bool:
    """Whether a folder was made for just this run."""
    try:
        return read_regular(folder / "case.toml").decode() == run.text
    except (OSError, ValueError):
        return False


def _end_of(run: Run, folder: Path) -> str:
    """How the run in a folder has ended, empty if it has not or is another one."""
    try:
        summary = json.loads(read_regular(folder / "summary.json"))
    except (OSError, ValueError):
        return ""
    if not _is_same(run, folder) or not isinstance(summary, dict):
        return ""
    return "interrupted" if summary.get(INTERRUPTED) else "end"


def read_results(folder: Path, average: float | None = None) -> dict[str, float]:
    """All numbers of ``summary.json`` by dotted key, and the last row of ``history.csv``.

    Of a name that both use, the one of the summary is taken.

    Args:
        average: Time at the end over which columns are averaged; None for the last row [s].
    """
    header, *rows = _read_table(folder)
    found = {name: _number(text) for name, text in zip(header, rows[-1], strict=True)}
    if average is not None:
        found = _average(header, rows, average)
    summary = json.loads(read_regular(folder / "summary.json"))
    numbers = {k: v for k, v in flatten(summary) if isinstance(v, int | float)}
    return numbers | {name: value for name, value in found.items() if name not in numbers}


def _read_table(folder: Path) -> list[list[str]]:
    """Head and rows of ``history.csv``."""
    return list(csv.reader(read_regular(folder / "history.csv").decode().splitlines()))


def find_drifts(folder: Path, average: float, quantities: Iterable[str]) -> dict[str, float]:
    """How far means of quantities over the two halves of the last time lie apart.

    Args:
        average: Time at the end over which columns are averaged [s].
        quantities: Columns of ``history.csv``, with or without unit; others are left out.

    Returns:
        By quantity the difference of the means over the larger of them, 0 where that is tiny [-].
    """
    header, *rows = _read_table(folder)
    end = float(rows[-1][header.index(TIME)])
    first = [
        row for row in rows if float(row[header.index(TIME)]) <= end - 0.5 * average * (1 - 1e-9)
    ]
    if not first:
        return {}
    before, after = (_average(header, part, 0.5 * average) for part in (first, rows))
    drifts = {}
    for name in dict.fromkeys(quantities):
        for column in (c for c in header if name in (c, split_unit(c)[0])):
            a, b = before[column], after[column]
            k, mean = header.index(column), max(abs(a), abs(b))
            largest = max(abs(_number(row[k])) for row in rows)
            is_none = mean < NOTHING * max(1.0, largest)
            drifts[name] = 0.0 if is_none else abs(a - b) / mean
    return drifts


def check_quantities(wanted: Iterable[str]) -> None:
    """Refuse names of quantities that no run writes."""
    given = [value for name, value in vars(names).items() if name.isupper()]
    families = [x for x in given if isinstance(x, names.Family)]
    families += [names.Family(x) for x in (*given, *names.SUMMARY) if isinstance(x, str)]
    for name in wanted:
        # turbines write one index of plies
        if not any(family.matches(name, criterion="tsai_wu") for family in families):
            near = suggest(name, [split_unit(family.pattern)[0] for family in families])
            raise InputError(f"quantity {name!r} is none that a run writes{near}")


def find_quantity(results: Mapping[str, float], name: str) -> str:
    """Full name of a quantity that is given with or without its unit."""
    if name in results:
        return name
    found = [full for full in results if split_unit(full)[0] == name]
    if len(found) == 1:
        return found[0]
    what = f"may be {' or '.join(found)}" if found else "is none of"
    choice = "" if found else f" {', '.join(results)}"
    raise InputError(f"quantity {name!r} {what}{choice}")


def write_table(
    path: Path,
    runs: Sequence[Run],
    results: Mapping[str, Mapping[str, float]],
    failed: Mapping[str, str],
    keys: Sequence[str],
    quantities: Sequence[str] = (),
) -> None:
    """Write one row for each run.

    Args:
        runs: The runs, in the order of the rows.
        results: Results of the finished runs by name.
        failed: Reasons of the failed runs by name.
        keys: Keys of the cases that become columns.
        quantities: Results that become columns; all if empty.
    """
    columns = list(dict.fromkeys(name for found in results.values() for name in found))
    if quantities and results:
        first = next(iter(results.values()))
        columns = [find_quantity(first, name) for name in quantities]
    temporary = path.with_suffix(".part")
    with temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["run", "state", *keys, *columns])
        for run in runs:
            found = results.get(run.name, {})
            state = "finished" if found else "failed" if run.name in failed else "not run"
            values = [
                json.dumps(v) if isinstance(v, list | tuple) else v for v in map(run.value, keys)
            ]
            writer.writerow([run.name, state, *values, *(found.get(name, "") for name in columns)])
    temporary.replace(path)


def format_lines(table: Iterable[Sequence[str]]) -> Iterator[str]:
    """Rows of text as lines, the first column to the left and all others to the right."""
    rows = [list(row) for row in table]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([first.ljust(widths[0]), *cells]).rstrip()


def _average(header: Sequence[str], rows: Sequence[Sequence[str]], time: float) -> dict[str, float]:
    """Means of columns over the last rows, by the trapezoidal rule; the time is the last."""
    table = np.array([[_number(text) for text in row] for row in rows])
    t = table[:, header.index(TIME)]
    table, t = (x[t >= t[-1] - time * (1.0 + 1e-9)] for x in (table, t))
    if len(t) < 2:
        means = table[-1]
    else:
        means = 0.5 * np.diff(t) @ (table[1:] + table[:-1]) / (t[-1] - t[0])
    return {**dict(zip(header, means.tolist(), strict=True)), TIME: float(t[-1])}


def _number(text: str) -> float:
    """An entry of the history."""
    return float(text) if text else float("nan")
