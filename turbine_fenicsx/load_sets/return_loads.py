"""Loads of return periods of the situations of a set that evaluate extrapolation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.load_sets.extrapolation import extrapolate
from turbine_fenicsx.load_sets.lifetime import make_bins
from turbine_fenicsx.load_sets.load_set import FEWEST_BLOCKS, LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.load_sets.run_loads import RunLoads
from turbine_fenicsx.records.mode_tables import format_rows
from turbine_fenicsx.turbine.life.weighted_run import YEAR

PERIODS = (1.0 / 365.25, 1.0 / 12.0, 1.0, 10.0, 50.0)
"""Return periods of the table beside that of the set [years]."""

REST = 1e-12
"""Columns whose extremes differ by less of their size rest, and have no distribution [-]."""


@dataclass(frozen=True)
class ReturnLoad:
    """A load of a return period.

    Args:
        side: "least" or "largest".
        period: [years].
        value: The load, in the unit of the column.
        low: Lower limit of confidence.
        high: Upper limit.
        seen: The extreme of the runs.
    """

    column: str
    side: str
    period: float
    value: float
    low: float
    high: float
    seen: float


def find_return_loads(
    load_set: LoadSet, runs: Sequence[SetRun], loads: Mapping[str, RunLoads], situation: str
) -> list[ReturnLoad]:
    """Loads of a situation that all of its runs have; none before each speed has enough blocks.

    Args:
        loads: Of finished runs.
        situation: Name of that whose runs are taken.
    """
    bins = make_bins(load_set, [situation], runs)
    own = [each for each in runs if each.situation == situation and each.run.name in loads]
    at_speed = {
        speed: [loads[each.run.name] for each in own if each.wind == speed] for speed in bins.speeds
    }
    numbers = [sum(len(each.least) for each in found) for found in at_speed.values()]
    if min(numbers) < FEWEST_BLOCKS:
        return []
    first, *others = (each for found in at_speed.values() for each in found)
    columns = [c for c in first.columns if all(c in each.columns for each in others)]
    shares = [bins.share(speed) for speed in bins.speeds]
    periods = sorted({*PERIODS, load_set.extremes.years})
    found: list[ReturnLoad] = []
    for side, sign in ("least", -1.0), ("largest", 1.0):
        blocks = [
            np.concatenate([sign * _choose(each, side, columns) for each in parts])
            for parts in at_speed.values()
        ]
        seen = np.max([values.max(axis=0) for values in blocks], axis=0)
        spread = np.max([np.ptp(values, axis=0) for values in blocks], axis=0)
        moving = spread > REST * np.abs(seen)
        results = extrapolate(
            [values[:, moving] for values in blocks],
            shares,
            load_set.extremes.block,
            [period * YEAR for period in periods],
        )
        names = [c for c, moves in zip(columns, moving, strict=True) if moves]
        for period, each in zip(periods, results, strict=True):
            low, high = (each.low, each.high) if sign > 0.0 else (-each.high, -each.low)
            table = zip(names, sign * each.loads, low, high, sign * seen[moving], strict=True)
            found += [ReturnLoad(c, side, period, *map(float, row)) for c, *row in table]
    return found


def _choose(loads: RunLoads, side: str, columns: Sequence[str]) -> Array:
    """Extremes of the blocks of a run, shape (blocks, columns)."""
    values: Array = getattr(loads, side)
    return values[:, [loads.columns.index(column) for column in columns]]


def format_return_loads(found: Mapping[str, Sequence[ReturnLoad]]) -> str:
    """``extrapolated.csv``: loads by situation; empty if there are none."""
    rows: list[dict[str, float | str]] = [
        {
            "situation": situation,
            "column": each.column,
            "side": each.side,
            "return_period_[years]": each.period,
            "value": each.value,
            "low": each.low,
            "high": each.high,
            "seen": each.seen,
        }
        for situation, loads in found.items()
        for each in sorted(loads, key=lambda load: (load.column, load.side, load.period))
    ]
    return format_rows(rows) if rows else ""
