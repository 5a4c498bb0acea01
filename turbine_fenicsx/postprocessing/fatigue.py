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
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.postprocessing.mode_tables import format_rows
from turbine_fenicsx.postprocessing.output_folder import TimeSeries

SLOPE, FREQUENCY = 10.0, 1.0
"""Of laminates with glass fibres [-]; of the cycles that damage is expressed in [Hz]."""


@dataclass(frozen=True)
class Fatigue:
    """Cycles of one column.

    Args:
        column: Its name; ranges have its unit.
        cycles: Number of cycles, halves included.
        largest: Largest range.
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

    Raises:
        ImportError: with a sentence, if the library is missing.
    """
    try:
        import rainflow
    except ImportError:
        raise ImportError("counting cycles needs rainflow: pip install rainflow") from None
    found = [(size, count) for size, _, count, _, _ in rainflow.extract_cycles(values.tolist())]
    ranges, counts = np.array(found, dtype=float).reshape(-1, 2).T
    return ranges, counts


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
    slopes: Sequence[float] = (SLOPE,),
    frequency: float = FREQUENCY,
    start: float = 0.0,
) -> list[Fatigue]:
    """Cycles and equivalent ranges of columns of a run.

    Args:
        series: The run.
        columns: Their names; empty for moments of roots and tower base, and strain gauges.
        slopes: Slopes of S-N curves [-].
        frequency: Of the equivalent cycles [Hz].
        start: Time before which nothing counts [s].

    Raises:
        InputError: if the run has no such column, or no step after the start.
        ImportError: with a sentence, if the library is missing.
    """
    chosen = list(columns) or list_loads(series)
    if not chosen:
        raise InputError(
            f"the run {series.name!r} has neither root moments nor strain gauges: choose other "
            "columns of its history.csv"
        )
    time, found = series[names.TIME], []
    for column in chosen:
        values = series[column]
        # loads are means over steps, and before the first step there are none
        there = np.isfinite(values) & (time >= start) & (np.arange(len(time)) > 0)
        if np.count_nonzero(there) < 2:
            raise InputError(
                f"column {column!r} has fewer than two numbers from t = {start:g} s on"
            )
        duration = float(np.ptp(time[there]))
        ranges, counts = count_cycles(values[there])
        equivalent = {m: equivalent_range(ranges, counts, m, frequency * duration) for m in slopes}
        largest = float(np.max(ranges, initial=0.0))
        found.append(Fatigue(column, float(counts.sum()), largest, equivalent))
    return found


def list_loads(series: TimeSeries) -> list[str]:
    """Columns of moments of roots and tower base, and of strain gauges."""
    found = [names.STRAIN.find(series.columns), names.TOWER_BASE_MOMENT.find(series.columns)]
    found += [names.ROOT_MOMENT.find(series.columns, axis=axis) for axis in "xyz"]
    loads = {column for columns in found for column in columns.values()}
    return [column for column in series.columns if column in loads]


def format_fatigue(found: Sequence[Fatigue]) -> str:
    """``fatigue.csv``: one line for each column; numbers read back exactly."""
    return format_rows(
        [
            {
                "column": each.column,
                "cycles": each.cycles,
                "largest_range": each.largest,
                **{f"equivalent_range_slope_{m:g}": x for m, x in each.equivalent.items()},
            }
            for each in found
        ]
    )
