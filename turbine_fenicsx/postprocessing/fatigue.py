"""Fatigue of a run: cycles of its columns, and the ranges that do the same damage.

Cycles are counted by the rainflow method of ASTM E1049-85, half cycles as one half. For an S-N
curve of slope m,

    S_eq = (sum_i n_i S_i^m / N)^(1/m)

is the range that does the same damage in N cycles: the damage-equivalent load. N is the duration of
the run times a frequency, 1 Hz by custom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import format_rows
from turbine_fenicsx.records.output_folder import TimeSeries

GLASS_SLOPE, STEEL_SLOPE, FREQUENCY = 10.0, 4.0, 1.0
"""Slopes for laminates with glass fibres and for steel [-]; frequency of equivalent cycles [Hz]."""

ROUND_OFF = 1e-12
"""Smaller ranges count as zero, as a part of the largest value."""

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


def count_cycles(
    values: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ranges of the cycles of a series, and how much each counts, 1 or 1/2; shapes (n,).

    Constant series have none, nor does round-off.
    """
    try:
        import rainflow
    except ImportError:
        raise ImportError("counting cycles needs rainflow: pip install rainflow") from None
    found = [(size, count) for size, _, count, _, _ in rainflow.extract_cycles(values.tolist())]
    ranges, counts = np.array(found, dtype=float).reshape(-1, 2).T
    are_cycles = ranges > ROUND_OFF * np.max(np.abs(values), initial=0.0)
    return ranges[are_cycles], counts[are_cycles]


def equivalent_range(
    ranges: NDArray[np.float64], counts: NDArray[np.float64], slope: float, cycles: float
) -> float:
    """Range that in a number of cycles does the damage of all that were counted."""
    largest = float(np.max(ranges, initial=0.0))
    if largest == 0.0:
        return 0.0
    damage = float(counts @ (ranges / largest) ** slope) / cycles
    return float(largest * damage ** (1.0 / slope))


def find_fatigue(
    series: TimeSeries,
    columns: Sequence[str] = (),
    slopes: Sequence[float] = (),
    frequency: float = FREQUENCY,
    start: float = 0.0,
) -> list[Fatigue]:
    """Cycles and equivalent ranges of columns of a run.

    Args:
        columns: Their names; empty for moments of roots and tower base, and strain gauges.
        slopes: Slopes of S-N curves [-]; empty for 4 of parts of steel and 10 of all others.
        frequency: Of the equivalent cycles [Hz].
        start: Time before which nothing counts [s].
    """
    chosen = list(columns) or list_loads(series)
    if not chosen:
        raise InputError(
            f"the run {series.name!r} has neither root moments nor strain gauges: choose other "
            "columns of its history.csv"
        )
    time, found = series[names.TIME], []
    _check_times(series.name, time)
    # loads are means over steps, and before the first step there are none
    there = (time >= start) & (np.arange(len(time)) > 0)
    for column in chosen:
        values = series[column]
        wrong = np.flatnonzero(there & ~np.isfinite(values))
        if len(wrong):
            raise InputError(
                f"column {column!r} has {len(wrong)} entries that are not finite, first "
                f"{values[wrong[0]]:g} at t = {time[wrong[0]]:g} s"
            )
        if np.count_nonzero(there) < 2:
            raise InputError(
                f"column {column!r} has fewer than two numbers from t = {start:g} s on"
            )
        duration = float(np.ptp(time[there]))
        ranges, counts = count_cycles(values[there])
        cycles = frequency * duration
        own = slopes or (find_slope(column),)
        equivalent = {m: equivalent_range(ranges, counts, m, cycles) for m in own}
        largest = float(np.max(ranges, initial=0.0))
        found.append(Fatigue(column, float(counts.sum()), largest, equivalent))
    return found


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
