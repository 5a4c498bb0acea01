"""Curves along the span of a blade or the height of a tower: stations and values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.entry import Entry

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

MAX_POINTS = 2000
"""Stations of a curve; the reference turbines have a hundred."""

_TOLERANCE = 1e-6
"""Stations may lie outside of 0 to 1 by this much."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Values at stations, straight between them and constant outside of them.

    Args:
        grid: Stations, rising, shape (n,) [-].
        values: Shape (n,).
    """

    grid: Array
    values: Array

    def __call__(self, s: Array | float) -> Array:
        """Values at span fractions of any shape."""
        return np.asarray(np.interp(s, self.grid, self.values))

    @property
    def start(self) -> float:
        """First station."""
        return float(self.grid[0])

    @property
    def end(self) -> float:
        """Last station."""
        return float(self.grid[-1])

    @property
    def integral(self) -> float:
        """Integral between the first and the last station."""
        return float(0.5 * (self.values[1:] + self.values[:-1]) @ np.diff(self.grid))

    @cached_property
    def _spline(self) -> PchipInterpolator:
        return make_spline(self.grid, self.values)

    def smooth(self, s: Array) -> Array:
        """The monotone cubic spline (PCHIP) through the same values."""
        return np.asarray(self._spline(np.clip(s, self.start, self.end)))

    def slope(self, s: Array) -> Array:
        """The derivative of `smooth`."""
        return np.asarray(self._spline(s, 1))


def make_spline(at: Array, values: Array) -> PchipInterpolator:
    """The monotone cubic spline through values along their first axis.

    SciPy's part for it is loaded here: that takes a quarter of what else a check of a case does.
    """
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(at, values)


def read_curve(
    entry: Entry,
    least: float = -inf,
    most: float = inf,
    whole: bool = False,
    round_off: float = 0.0,
) -> Curve:
    """The curve of a table of windIO with `grid` and `values`.

    Args:
        whole: Whether it must reach from 0 to 1.
        round_off: Values below the least one by as much are taken for it.
    """
    values = entry["values"]
    grid = read_grid(entry["grid"])
    if isinstance(values.value, list) and values.value and isinstance(values.value[0], list):
        values.fail("vary around the section, which is not read: give one value a station")
    curve = Curve(grid, values.numbers())
    close = (curve.values < least) & (curve.values >= least - round_off)
    curve = Curve(grid, np.where(close, least, curve.values)) if close.any() else curve
    if len(curve.values) != len(grid):
        entry.fail(f"has {len(grid)} stations in its grid, but {len(curve.values)} values")
    for s, value in zip(grid, curve.values, strict=True):
        if not least <= value <= most:
            allowed = f"between {least:g} and {most:g}" if most < inf else f"at least {least:g}"
            entry.fail(f"must be {allowed}, got {value:g} at station {s:g}")
    if whole and (curve.start > _TOLERANCE or curve.end < 1.0 - _TOLERANCE):
        entry.fail(f"must reach from 0 to 1, got {curve.start:g} to {curve.end:g}")
    return curve


def read_grid(entry: Entry) -> Array:
    """Stations: at least two, rising, from 0 to 1 at most, shape (n,) [-]."""
    grid = entry.numbers()
    if len(grid) and (grid.min() < -_TOLERANCE or grid.max() > 1.0 + _TOLERANCE):
        entry.fail(f"must lie between 0 and 1, got {grid.min():g} to {grid.max():g}")
    grid = np.clip(grid, 0.0, 1.0)
    if len(grid) > MAX_POINTS:
        entry.fail(f"must have at most {MAX_POINTS} stations, got {len(grid)}")
    if len(grid) < 2:
        entry.fail(f"must have at least two stations, got {len(grid)}")
    falling = np.flatnonzero(np.diff(grid) <= 0.0)
    if len(falling):
        k = int(falling[0])
        entry.fail(f"must rise from station to station, {grid[k]:g} is followed by {grid[k + 1]:g}")
    return grid
