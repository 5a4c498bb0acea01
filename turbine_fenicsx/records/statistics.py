"""Mean, deviation and extremes of the columns of a run: ``statistics.csv``.

A row belongs to the step that ends at its time, so that with the lengths h_i of the steps

    mean = sum h_i x_i / sum h_i,    deviation^2 = sum h_i (x_i - mean)^2 / sum h_i.
"""

from __future__ import annotations

import csv
import os
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.records.names import TIME, WALL_TIME
from turbine_fenicsx.records.output_folder import TimeSeries, add_openfast, read_history
from turbine_fenicsx.records.row_file import join_columns

STATISTICS = "statistics.csv"
"""Name of the table in an output folder."""


@dataclass(frozen=True)
class ColumnStatistics:
    """Statistics of a column, in its unit; times in s."""

    column: str
    mean: float
    deviation: float
    least: float
    time_of_least: float
    largest: float
    time_of_largest: float


def find_statistics(series: TimeSeries, begin: float = 0.0) -> list[ColumnStatistics]:
    """Statistics of all columns of a run.

    Args:
        series: The run, from its first row on.
        begin: Rows up to this time are left out, and the first one always [s].

    Raises:
        InputError: if no row is left.
    """
    time = series[TIME]
    steps = np.diff(time, prepend=time[0])
    chosen = (steps > 0.0) & (time > begin)
    if not chosen.any():
        raise InputError(f"'{series.name}' has no row after {begin:g} s")
    t, weights = time[chosen], steps[chosen] / steps[chosen].sum()
    found = []
    for column, values in series.columns.items():
        x = values[chosen]
        if column in (TIME, WALL_TIME) or not np.isfinite(x).all():
            continue
        mean = float(weights @ x)
        deviation = float(np.sqrt(weights @ (x - mean) ** 2))
        low, high = int(np.argmin(x)), int(np.argmax(x))
        extremes = (float(v) for v in (x[low], t[low], x[high], t[high]))
        found.append(ColumnStatistics(column, mean, deviation, *extremes))
    return found


def read_both_histories(folder: str | os.PathLike[str]) -> TimeSeries:
    """Columns of ``history.out`` and ``history.csv`` of a run, from the initial state on.

    Columns of ``history.out`` come first, and are zero in the initial state, which it lacks.

    Raises:
        InputError: for files that are missing or damaged.
    """
    history = read_history(Path(folder) / "history.csv")
    out = add_openfast(history, Path(folder) / "history.out")
    n = len(out[TIME]) + 1
    columns = {c: np.append(0.0, x) for c, x in out.columns.items() if c != TIME}
    columns |= {c: x[:n] for c, x in history.columns.items()}
    return TimeSeries(history.name, columns)


def write_statistics(folder: str | os.PathLike[str], begin: float = 0.0) -> None:
    """Write the statistics of both histories of a run; nothing if no row is late enough.

    Args:
        begin: As in `find_statistics`.
    """
    folder = Path(folder)
    try:
        found = find_statistics(read_both_histories(folder), begin)
    except InputError:  # a run of no step, or shorter than what is left out
        (folder / STATISTICS).unlink(missing_ok=True)
        return
    head = join_columns([f"{f.name}_[s]" if "time" in f.name else f.name for f in fields(found[0])])
    rows = [join_columns([str(x) for x in astuple(each)]) for each in found]
    replace_file(folder / STATISTICS, "".join(f"{line}\n" for line in (head, *rows)).encode())


def read_statistics(folder: str | os.PathLike[str]) -> list[ColumnStatistics]:
    """The statistics of a run; none if there is no such file.

    Raises:
        InputError: for a file that has other columns.
    """
    path = Path(folder) / STATISTICS
    if not path.exists():
        return []
    try:
        with path.open(encoding="utf-8", newline="") as file:
            _, *rows = csv.reader(file)
        return [ColumnStatistics(row[0], *(float(x) for x in row[1:])) for row in rows]
    except (OSError, TypeError, ValueError, csv.Error) as error:
        raise InputError(f"{path} is not a table of statistics: {error}") from None
