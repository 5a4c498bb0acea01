"""Cycles of a load: their ranges and means, Goodman's correction of means, and Markov matrices.

Cycles are counted by the rainflow method of ASTM E1049-85, half cycles as one half. A cycle of
range S about the mean M does the damage of one about zero with the range (Goodman)

    S_0 = S S_u/(S_u - |M|),

where S_u is the ultimate load. A Markov matrix has the numbers of cycles in cells of ranges and
means.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.mode_tables import format_rows

ROUND_OFF = 1e-12
"""Smaller ranges count as zero, as a part of the largest value."""

CELLS = 50
"""Cells of a Markov matrix along ranges, and along means."""


@dataclass(frozen=True, eq=False)
class Cycles:
    """Cycles of a load, arrays of shape (n,).

    Args:
        ranges: From trough to crest.
        means: Middles between trough and crest.
        counts: How much each counts, 1 or 1/2, or times its weight.
    """

    ranges: Array
    means: Array
    counts: Array

    def weigh(self, weight: float) -> Cycles:
        """The cycles with counts times a weight."""
        return replace(self, counts=weight * self.counts)


def count_cycles(values: Array) -> Cycles:
    """Cycles of a series of shape (n,); constant series have none, nor does round-off.

    Raises:
        ImportError: if rainflow is missing.
    """
    try:
        import rainflow
    except ImportError:
        raise ImportError("counting cycles needs rainflow: pip install rainflow") from None
    found = [entry[:3] for entry in rainflow.extract_cycles(values.tolist())]
    ranges, means, counts = np.array(found, dtype=float).reshape(-1, 3).T
    real = ranges > ROUND_OFF * np.max(np.abs(values), initial=0.0)
    return Cycles(ranges[real], means[real], counts[real])


def join_cycles(parts: Sequence[Cycles]) -> Cycles:
    """The cycles of all parts."""
    names = ("ranges", "means", "counts")
    return Cycles(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


# S_0 = S S_u/(S_u - |M|)
def correct_means(cycles: Cycles, ultimate: float, column: str) -> Cycles:
    """Cycles about zero that do the same damage, by Goodman.

    Args:
        ultimate: The load S_u that breaks the part.
        column: Name for messages.

    Raises:
        InputError: if a cycle reaches the ultimate load.
    """
    largest = float(np.max(np.abs(cycles.means) + 0.5 * cycles.ranges, initial=0.0))
    if not largest < ultimate:
        raise InputError(
            f"the ultimate load of {column!r} is {ultimate:g}: expected more than its largest "
            f"value {largest:g}"
        )
    factors = ultimate / (ultimate - np.abs(cycles.means))
    return Cycles(cycles.ranges * factors, np.zeros_like(cycles.means), cycles.counts)


def equivalent_range(cycles: Cycles, slope: float, number: float) -> float:
    """Range that in a number of cycles does the damage of all that were counted."""
    largest = float(np.max(cycles.ranges, initial=0.0))
    if largest == 0.0:
        return 0.0
    damage = float(cycles.counts @ (cycles.ranges / largest) ** slope) / number
    return float(largest * damage ** (1.0 / slope))


def format_markov(loads: Mapping[str, Cycles]) -> str:
    """``markov.csv``: a row for each cell of each load that has cycles.

    The cells of a load divide ranges from 0 to the largest one and the means that occur.

    Args:
        loads: Cycles by the name of the load.
    """
    rows: list[dict[str, float | str]] = []
    for column, cycles in loads.items():
        if not len(cycles.ranges):
            continue
        largest, low, high = cycles.ranges.max(), cycles.means.min(), cycles.means.max()
        width = max(high - low, ROUND_OFF * largest)  # of one mean
        sides = [
            np.linspace(0.0, largest, CELLS + 1),
            low + width * np.linspace(0.0, 1.0, CELLS + 1),
        ]
        table, *_ = np.histogram2d(cycles.ranges, cycles.means, sides, weights=cycles.counts)
        range_, mean = (0.5 * (edges[1:] + edges[:-1]) for edges in sides)
        for i, j in np.argwhere(table > 0.0):
            values = {
                "range": float(range_[i]),
                "mean": float(mean[j]),
                "cycles": float(table[i, j]),
            }
            rows.append({"column": column, **values})
    return format_rows(rows) if rows else ""
