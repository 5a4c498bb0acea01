"""Parametric description of a blade and of the rotor that carries copies of it.

A blade has its own frame: a1 along the span, a2 along the chord, a3 along the thickness, with the
origin at the rotor centre, so that the first coordinate of a point is its radius. At every radius
the section is an ellipse.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import cos, isfinite, pi, sin, tan
from numbers import Real
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True)
class BladeGeometry:
    """Solid blade with elliptic sections that vary piecewise linearly along the span.

    Attributes:
        hub_radius: Radius of the hub surface, where the blade begins [m].
        length: Length of the blade from the hub surface to its tip [m].
        stations: Positions along the span as fractions of the length, from 0 to 1 [-].
        chord: Full width of the section in the chord direction, one per station [m].
        thickness: Full width of the section in the thickness direction, one per station [m].
    """

    hub_radius: float = 2.25
    length: float = 54.0
    stations: tuple[float, ...] = (0.0, 0.2, 1.0)
    chord: tuple[float, ...] = (1.8, 3.0, 0.6)
    thickness: tuple[float, ...] = (1.8, 1.5, 0.2)

    def __post_init__(self) -> None:
        _require_positive("blade.hub_radius", self.hub_radius)
        _require_positive("blade.length", self.length)
        for name in ("stations", "chord", "thickness"):
            object.__setattr__(self, name, _numbers(f"blade.{name}", getattr(self, name)))
        ordered = all(left < right for left, right in pairwise(self.stations))
        if len(self.stations) < 2 or (self.stations[0], self.stations[-1]) != (0.0, 1.0):
            ordered = False
        if not ordered:
            raise ModelError(
                f"blade.stations = {self.stations}: give increasing fractions of the span that "
                "begin with 0 and end with 1"
            )
        for name in ("chord", "thickness"):
            widths = getattr(self, name)
            if len(widths) != len(self.stations):
                raise ModelError(
                    f"blade.{name} = {widths}: give one width per station, that is "
                    f"{len(self.stations)} numbers"
                )
            for width in widths:
                _require_positive(f"blade.{name}", width)

    def chord_at(self, fraction: float | Array) -> Array:
        """Return the chord [m] at fractions of the span [-], in the shape of the argument."""
        return np.asarray(np.interp(fraction, self.stations, self.chord))

    def thickness_at(self, fraction: float | Array) -> Array:
        """Return the thickness [m] at fractions of the span [-], in the shape of the argument."""
        return np.asarray(np.interp(fraction, self.stations, self.thickness))

    @property
    def kinks(self) -> tuple[float, ...]:
        """The stations where the slope of chord or thickness changes, with both ends [-]."""
        slopes = [
            np.diff(widths) / np.diff(self.stations) for widths in (self.chord, self.thickness)
        ]
        inner = [
            station
            for i, station in enumerate(self.stations[1:-1])
            if not all(np.isclose(s[i], s[i + 1], rtol=1e-12, atol=1e-12) for s in slopes)
        ]
        return (0.0, *inner, 1.0)

    @property
    def volume(self) -> float:
        """Exact volume, the integral of pi/4 chord thickness over the span [m^3]."""
        s, c, t = (np.asarray(a) for a in (self.stations, self.chord, self.thickness))
        # Simpson's rule is exact: the integrand is quadratic between two stations.
        product = c[:-1] * t[:-1] + (c[:-1] + c[1:]) * (t[:-1] + t[1:]) + c[1:] * t[1:]
        return float(pi / 4 * self.length * np.sum(np.diff(s) * product / 6))


@dataclass(frozen=True)
class RotorLayout:
    """Where the blades of a rotor stand.

    The span of a blade at azimuth 0 points along ``up``; a positive azimuth turns it about the
    axis by the right-hand rule. The default rotor is the paper's: blade 2 points up (body 4),
    blades 1 and 3 point 30 degrees below the horizontal, blade 1 (body 3) towards +e1 and
    blade 3 (body 5) towards -e1.

    Attributes:
        centre: Rotor centre, the common origin of all blade frames [m].
        axis: Direction of the rotor axis [-].
        up: Direction of azimuth 0; its part along the axis is ignored [-].
        azimuths: Azimuth of each blade [rad].
        pitch: Rotation of every blade about its own span; at 0 the thickness direction is the
            rotor axis and the chord lies in the rotor plane [rad].
    """

    centre: tuple[float, ...] = (0.0, 0.0, 5.0)
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    up: tuple[float, ...] = (0.0, 1.0, 0.0)
    azimuths: tuple[float, ...] = (-2 * pi / 3, 0.0, 2 * pi / 3)
    pitch: float = 0.0

    def __post_init__(self) -> None:
        for name in ("centre", "axis", "up"):
            vector = _numbers(f"rotor.{name}", getattr(self, name))
            if len(vector) != 3:
                raise ModelError(f"rotor.{name} = {vector}: give three numbers")
            object.__setattr__(self, name, vector)
        object.__setattr__(self, "azimuths", _numbers("rotor.azimuths", self.azimuths))
        _numbers("rotor.pitch", [self.pitch])
        if not self.azimuths:
            raise ModelError("rotor.azimuths = (): give at least one azimuth")
        if np.linalg.norm(self.axis) == 0:
            raise ModelError(f"rotor.axis = {self.axis}: give a direction other than zero")
        if np.linalg.norm(np.cross(self.axis, self.up)) <= 1e-12 * np.linalg.norm(self.up):
            raise ModelError(f"rotor.up = {self.up}: give a direction that is not along the axis")

    @property
    def n_blades(self) -> int:
        """Number of blades."""
        return len(self.azimuths)

    @property
    def volume_groups(self) -> tuple[str, ...]:
        """Names of the physical volumes: blade_1, blade_2, ..."""
        return tuple(f"blade_{k + 1}" for k in range(self.n_blades))

    @property
    def surface_groups(self) -> tuple[str, ...]:
        """Names of the physical surfaces: root_1, skin_1, root_2, ..."""
        return tuple(f"{part}_{k + 1}" for k in range(self.n_blades) for part in ("root", "skin"))

    def frame(self, blade: int) -> Array:
        """Return the frame of a blade: rows a1 (span), a2 (chord), a3 (thickness).

        Args:
            blade: Number of the blade, from 1.

        Returns:
            Rotation matrix with the right-handed orthonormal axes as rows, shape (3, 3) [-].
        """
        if not 1 <= blade <= self.n_blades:
            raise ModelError(f"blade {blade} does not exist: choose from 1 to {self.n_blades}")
        e3 = np.asarray(self.axis) / np.linalg.norm(self.axis)
        e1 = np.cross(self.up, e3)
        e1 /= np.linalg.norm(e1)
        e2 = np.cross(e3, e1)
        azimuth = self.azimuths[blade - 1]
        a1 = cos(azimuth) * e2 - sin(azimuth) * e1
        chord, thickness = np.cross(e3, a1), e3
        a2 = cos(self.pitch) * chord + sin(self.pitch) * thickness
        a3 = cos(self.pitch) * thickness - sin(self.pitch) * chord
        return np.stack([a1, a2, a3])

    def place(self, points: Array, blade: int) -> Array:
        """Map points from the frame of a blade to space.

        Args:
            points: Coordinates along a1, a2, a3 from the rotor centre, shape (n, 3) [m].
            blade: Number of the blade, from 1.

        Returns:
            Coordinates along e1, e2, e3, shape (n, 3) [m].
        """
        placed: Array = np.asarray(self.centre) + points @ self.frame(blade)
        return placed

    def check_clearance(self, blade: BladeGeometry) -> None:
        """Raise ModelError if the roots of two neighbouring blades overlap."""
        angles = np.sort(np.mod(self.azimuths, 2 * pi))
        gap = float(np.min(np.diff(angles, append=angles[0] + 2 * pi)))
        half_width = max(blade.chord[0], blade.thickness[0]) / 2
        if gap < pi and blade.hub_radius * tan(gap / 2) < half_width:
            raise ModelError(
                f"rotor.azimuths = {self.azimuths}: two blades only {np.degrees(gap):.4g} degrees "
                f"apart overlap at a hub radius of {blade.hub_radius:g} m"
            )


def _numbers(key: str, values: Iterable[float]) -> tuple[float, ...]:
    """Return finite numbers as a tuple of floats, or raise ModelError with the key."""
    items: list[Any] = list(values) if isinstance(values, Iterable) else [None]
    if not all(isinstance(item, Real) and isfinite(item) for item in items):
        raise ModelError(f"{key} = {values!r}: give finite numbers")
    return tuple(float(item) for item in items)


def _require_positive(key: str, value: float) -> None:
    """Raise ModelError unless the value is a finite number above zero."""
    if not _numbers(key, [value])[0] > 0:
        raise ModelError(f"{key} = {value!r}: must be greater than 0")
