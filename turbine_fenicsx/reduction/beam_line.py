"""The reference axis of a beam with the directors of its sections."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

FINE = 4000
"""Points along an axis that measure its arc length."""


@dataclass(frozen=True, eq=False)
class BeamLine:
    """Reference axis and directors of a beam, smooth through those at stations.

    Sections are at right angles to the axis: directors are made so, with the first one kept as it
    is as far as possible.

    Args:
        stations: Rising, of any unit, shape (m,).
        points: Axis at these, shape (m, 3) [m].
        directors: Axes x and y of the section there, shape (m, 2, 3) [-].

    Raises:
        ModelError: for other shapes, stations that do not rise, points that coincide, and
            directors along the axis.
    """

    stations: Array
    points: Array
    directors: Array

    def __post_init__(self) -> None:
        m = len(np.atleast_1d(self.stations))
        for name, shape in (("stations", (m,)), ("points", (m, 3)), ("directors", (m, 2, 3))):
            words = f"finite numbers of the shape {shape}"
            values = check_array(f"{name} of a beam", getattr(self, name), shape, words)
            object.__setattr__(self, name, values)
        if m < 2 or np.any(np.diff(self.stations) <= 0.0):
            raise ModelError("stations of a beam must be two or more and rise")
        if np.any(np.linalg.norm(np.diff(self.points, axis=0), axis=1) == 0.0):
            raise ModelError("points of the axis of a beam must differ from each other")

    @classmethod
    def straight(cls, length: float, twist: float = 0.0) -> BeamLine:
        """A beam along z from the origin, which turns about it evenly by a twist [rad]."""
        s = np.linspace(0.0, 1.0, 101)
        angle = s * twist
        c, n, z = np.cos(angle), np.sin(angle), np.zeros_like(s)
        directors = np.stack([np.column_stack([c, n, z]), np.column_stack([-n, c, z])], axis=1)
        return cls(s, np.outer(s, [0.0, 0.0, length]), directors)

    @cached_property
    def _axis(self) -> CubicSpline:
        return CubicSpline(self.stations, self.points)

    @cached_property
    def _directors(self) -> CubicSpline:
        return CubicSpline(self.stations, self.directors)

    @cached_property
    def _arcs(self) -> tuple[Array, Array]:
        """Stations and the arc length up to these [m]."""
        fine = np.unique(
            np.concatenate([np.linspace(self.stations[0], self.stations[-1], FINE), self.stations])
        )
        # Simpson's rule for each part
        speed = np.linalg.norm(self._axis(fine, 1), axis=1)
        middle = np.linalg.norm(self._axis(0.5 * (fine[1:] + fine[:-1]), 1), axis=1)
        parts = np.diff(fine) * (speed[1:] + 4.0 * middle + speed[:-1]) / 6.0
        return fine, np.concatenate([[0.0], np.cumsum(parts)])

    @property
    def length(self) -> float:
        """Arc length of the axis [m]."""
        return float(self._arcs[1][-1])

    def arc_length(self, stations: Array) -> Array:
        """Arc length from the start up to stations [m]."""
        return np.asarray(np.interp(stations, *self._arcs))

    def at(self, s: Array) -> tuple[Array, Array]:
        """Points, shape (k, 3) [m], and directors, shape (k, 2, 3), at arc lengths, shape (k,)."""
        stations = np.interp(s, *self._arcs[::-1])
        d1, d2 = self._directors(stations).swapaxes(0, 1)
        t = unit_rows(self._axis(stations, 1))
        d1 = d1 - np.sum(d1 * t, axis=1)[:, None] * t
        if np.any(np.linalg.norm(d1, axis=1) < 0.1):
            raise ModelError("directors of a beam must not lie along its axis")
        d1 = unit_rows(d1)
        second = np.cross(t, d1)
        if np.any(np.sum(second * d2, axis=1) <= 0.0):
            raise ModelError(
                "directors of a beam must be right-handed: the first one times the second one "
                "points along the axis"
            )
        return self._axis(stations), np.stack([d1, second], axis=1)


def unit_rows(vectors: Array) -> Array:
    """Unit vectors of vectors, shape (k, 3)."""
    found: Array = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    return found
