"""Fatigue of a run: cycles of its columns, and the ranges that do the same damage.

For an S-N curve of slope m,

    S_eq = (sum_i n_i S_i^m / N)^(1/m)

is the range that does the same damage in N cycles: the damage-equivalent load. N is the duration of
the run times a frequency, 1 Hz by custom.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.cycles import (
    Cycles,
    correct_means,
    count_cycles,
    equivalent_range,
)
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import format_rows
from turbine_fenicsx.records.output_folder import TimeSeries

GLASS_SLOPE, STEEL_SLOPE, FREQUENCY = 10.0, 4.0, 1.0
"""Slopes for laminates with glass fibres and for steel [-]; frequency of equivalent cycles [Hz]."""

STEEL = ("tower", "Twr", "YawBr", "LSS", "HSS", "Rot")
"""Beginnings of columns of parts that are of steel: tower, bearings and shafts."""


@dataclass(frozen=True)
class Fatigue:
    """Cycles of one column.

    Args:
        cycles: Number of cycles, halves included.
        equivalent: Equivalent range by the slope of the S-N curve.
    """

    column: str
    cycles: float
    largest: float
    equivalent: dict[float, float]


def find_cycles(
    series: TimeSeries, columns: Sequence[str] = (), start: float = 0.0
) -> dict[str, Cycles]:
    """Cycles of columns of a run, by their names.

    Args:
        columns: Empty for moments of roots and tower base, and strain gauges.
        start: Time before which nothing counts [s].

    Raises:
        InputError: for columns that are missing or not finite.
    """
    chosen = list(columns) or list_loads(series)
    if not chosen:
        raise InputError(
            f"the run {series.name!r} has neither root moments nor strain gauges: choose other "
            "columns of its history.csv"
        )
    time, counted = series[names.TIME], _find_counted(series, start)
    found = {}
    for column in chosen:
        values = series[column]
        wrong = np.flatnonzero(counted & ~np.isfinite(values))
        if len(wrong):
            raise InputError(
                f"column {column!r} has {len(wrong)} entries that are not finite, first "
                f"{values[wrong[0]]:g} at t = {time[wrong[0]]:g} s"
            )
        if np.count_nonzero(counted) < 2:
            raise InputError(
                f"column {column!r} has fewer than two numbers from t = {start:g} s on"
            )
        found[column] = count_cycles(values[counted])
    return found


def find_fatigue(
    series: TimeSeries,
    columns: Sequence[str] = (),
    slopes: Sequence[float] = (),
    frequency: float = FREQUENCY,
    start: float = 0.0,
    ultimate: Mapping[str, float] | None = None,
) -> list[Fatigue]:
    """Cycles and equivalent ranges of columns of a run.

    Args:
        columns: As of `find_cycles`.
        slopes: Slopes of S-N curves [-]; empty for 4 of parts of steel and 10 of all others.
        frequency: Of the equivalent cycles [Hz].
        start: Time before which nothing counts [s].
        ultimate: Ultimate loads of the columns whose means count, see
            `turbine_fenicsx.postprocessing.cycles.correct_means`.

    Raises:
        InputError: as `find_cycles`, and for ultimate loads that a cycle reaches.
    """
    loads = find_cycles(series, columns, start)
    number = frequency * float(np.ptp(series[names.TIME][_find_counted(series, start)]))
    found = []
    for column, cycles in loads.items():
        if ultimate and column in ultimate:
            cycles = correct_means(cycles, ultimate[column], column)
        own = slopes or (find_slope(column),)
        equivalent = {m: equivalent_range(cycles, m, number) for m in own}
        largest = float(np.max(cycles.ranges, initial=0.0))
        found.append(Fatigue(column, float(cycles.counts.sum()), largest, equivalent))
    return found


def _find_counted(series: TimeSeries, start: float) -> NDArray[np.bool_]:
    """Rows that count; loads are means over steps, and before the first step there are none."""
    time = series[names.TIME]
    _check_times(series.name, time)
    counted: NDArray[np.bool_] = (time >= start) & (np.arange(len(time)) > 0)
    return counted


def _check_times(name: str, time: NDArray[np.float64]) -> None:
    """Raise an InputError for times that do not rise."""
    back = np.flatnonzero(~(np.diff(time) > 0.0))
    if len(back):
        k = int(back[0])
        raise InputError(
            f"times of the run {name!r} do not rise: {time[k + 1]:g} s comes after {time[k]:g} s"
        )


def find_slope(column: str) -> float:
    """Slope of the S-N curve for what a column is about: steel, or else glass fibre."""
    return STEEL_SLOPE if column.startswith(STEEL) else GLASS_SLOPE


def list_loads(series: TimeSeries) -> list[str]:
    """Columns of moments of roots and tower base, and of strain gauges."""
    found = [names.STRAIN.find(series.columns), names.TOWER_BASE_MOMENT.find(series.columns)]
    found += [names.ROOT_MOMENT.find(series.columns, axis=axis) for axis in "xyz"]
    loads = {column for columns in found for column in columns.values()}
    return [column for column in series.columns if column in loads]


def format_fatigue(found: Sequence[Fatigue]) -> str:
    """``fatigue.csv``: one line for each column; numbers read back exactly."""
    slopes = list_slopes(found)
    return format_rows(
        [
            {
                "column": each.column,
                "cycles": each.cycles,
                "largest_range": each.largest,
                **{f"equivalent_range_slope_{m:g}": each.equivalent.get(m, "") for m in slopes},
            }
            for each in found
        ]
    )


def list_slopes(found: Sequence[Fatigue]) -> list[float]:
    """All slopes of some columns, rising."""
    return sorted({m for each in found for m in each.equivalent})
