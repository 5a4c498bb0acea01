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
    """Blade with elliptic sections that vary piecewise linearly along the span.

    Attributes:
        hub_radius: Radius of the hub surface, where the blade begins [m].
        length: Length of the blade from the hub surface to its tip [m].
        stations: Positions along the span as fractions of the length, from 0 to 1 [-].
        chord: Full width of the section in the chord direction, one per station [m].
        thickness: Full width of the section in the thickness direction, one per station [m].
        wall: Thickness of the wall of a hollow blade, one per station [m]; None: it is solid.
        twist: Angle by which the leading edge is turned against the thickness direction, one per
            station [rad]; None: none.
    """

    hub_radius: float = 2.25
    length: float = 54.0
    stations: tuple[float, ...] = (0.0, 0.2, 1.0)
    chord: tuple[float, ...] = (1.8, 3.0, 0.6)
    thickness: tuple[float, ...] = (1.8, 1.5, 0.2)
    wall: tuple[float, ...] | None = None
    twist: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        _require_positive("blade.hub_radius", self.hub_radius)
        _require_positive("blade.length", self.length)
        given = [name for name in ("wall", "twist") if getattr(self, name) is not None]
        for name in ("stations", "chord", "thickness", *given):
            object.__setattr__(self, name, _check_numbers(f"blade.{name}", getattr(self, name)))
        ordered = all(left < right for left, right in pairwise(self.stations))
        if len(self.stations) < 2 or (self.stations[0], self.stations[-1]) != (0.0, 1.0):
            ordered = False
        if not ordered:
            raise ModelError(
                f"blade.stations = {self.stations}: give increasing fractions of the span that "
                "begin with 0 and end with 1"
            )
        for name in ("chord", "thickness", *given):
            values = getattr(self, name)
            if len(values) != len(self.stations):
                raise ModelError(
                    f"blade.{name} = {values}: give one number per station, that is "
                    f"{len(self.stations)} numbers"
                )
            for value in values if name != "twist" else ():
                _require_positive(f"blade.{name}", value)
        for wall, chord, thickness in zip(
            self.wall or (), self.chord, self.thickness, strict=False
        ):
            if wall >= min(chord, thickness) / 2.0:
                raise ModelError(
                    f"blade.wall = {wall:g}: leaves no hollow, expected less than "
                    f"{min(chord, thickness) / 2.0:g} m, half of the section there"
                )

    def chord_at(self, fraction: float | Array) -> Array:
        """Return the chord [m] at fractions of the span [-], in the shape of the argument."""
        return np.asarray(np.interp(fraction, self.stations, self.chord))

    def thickness_at(self, fraction: float | Array) -> Array:
        """Return the thickness [m] at fractions of the span [-], in the shape of the argument."""
        return np.asarray(np.interp(fraction, self.stations, self.thickness))

    def wall_at(self, fraction: float | Array) -> Array:
        """Return the thickness of the wall [m] at fractions of the span [-] of a hollow blade."""
        assert self.wall is not None
        return np.asarray(np.interp(fraction, self.stations, self.wall))

    def twist_at(self, fraction: float | Array) -> Array:
        """Return the twist [rad] at fractions of the span [-], in the shape of the argument."""
        return np.asarray(
            np.interp(fraction, self.stations, self.twist or (0.0,) * len(self.chord))
        )

    def turn(self, points: Array) -> Array:
        """Return points of the untwisted blade where the twist takes them.

        Args:
            points: Coordinates along a1, a2, a3 from the rotor centre, shape (..., 3) [m].
        """
        if self.twist is None:
            return points
        twist = self.twist_at((points[..., 0] - self.hub_radius) / self.length)
        c, s = np.cos(twist), np.sin(twist)
        x, y, z = np.moveaxis(points, -1, 0)
        return np.stack([x, c * y + s * z, c * z - s * y], axis=-1)

    @property
    def kinks(self) -> tuple[float, ...]:
        """The stations where the slope of a width or of the twist changes, with both ends [-]."""
        changing = (self.chord, self.thickness, self.wall, self.twist)
        slopes = [np.diff(values) / np.diff(self.stations) for values in changing if values]
        inner = [
            station
            for i, station in enumerate(self.stations[1:-1])
            if not all(np.isclose(s[i], s[i + 1], rtol=1e-12, atol=1e-12) for s in slopes)
        ]
        return (0.0, *inner, 1.0)

    @property
    def volume(self) -> float:
        """Exact volume, the integral over the span of the area of a section [m^3].

        It is pi/4 chord thickness, of a ring of even thickness perimeter wall - pi wall^2.
        """
        s, c, t = (np.asarray(a) for a in (self.stations, self.chord, self.thickness))
        if self.wall is not None:
            return self._integrate_rings()
        # Simpson's rule is exact: the integrand is quadratic between two stations.
        product = c[:-1] * t[:-1] + (c[:-1] + c[1:]) * (t[:-1] + t[1:]) + c[1:] * t[1:]
        return float(pi / 4 * self.length * np.sum(np.diff(s) * product / 6))

    def _integrate_rings(self) -> float:
        """Volume of the wall by Gauss's rule between stations, exact to round-off."""
        from scipy.special import ellipe, roots_legendre

        nodes, weights = roots_legendre(12)
        s, steps = np.asarray(self.stations), np.diff(self.stations)
        at = s[:-1, None] + steps[:, None] * (nodes + 1.0) / 2.0
        wide, narrow = np.sort([self.chord_at(at), self.thickness_at(at)], axis=0)[::-1] / 2.0
        perimeter = 4.0 * wide * ellipe(1.0 - (narrow / wide) ** 2)
        wall = self.wall_at(at)
        ring = (perimeter - pi * wall) * wall
        return float(self.length * np.sum(steps[:, None] * weights / 2.0 * ring))


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
        cone: Angle between the spans and the plane normal to the axis, positive towards the axis,
            downwind [rad].
    """

    centre: tuple[float, ...] = (0.0, 0.0, 5.0)
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    up: tuple[float, ...] = (0.0, 1.0, 0.0)
    azimuths: tuple[float, ...] = (-2 * pi / 3, 0.0, 2 * pi / 3)
    pitch: float = 0.0
    cone: float = 0.0

    def __post_init__(self) -> None:
        for name in ("centre", "axis", "up"):
            vector = _check_numbers(f"rotor.{name}", getattr(self, name))
            if len(vector) != 3:
                raise ModelError(f"rotor.{name} = {vector}: give three numbers")
            object.__setattr__(self, name, vector)
        object.__setattr__(self, "azimuths", _check_numbers("rotor.azimuths", self.azimuths))
        _check_numbers("rotor.pitch", [self.pitch])
        if not -pi / 2 < _check_numbers("rotor.cone", [self.cone])[0] < pi / 2:
            raise ModelError(f"rotor.cone = {self.cone:g}: must be between -pi/2 and pi/2 rad")
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

    @property
    def axes(self) -> Array:
        """Axes of the rotor as rows (horizontal if ``up`` is vertical, up, axis), shape (3, 3)."""
        axis = np.asarray(self.axis) / np.linalg.norm(self.axis)
        side = np.cross(self.up, axis)
        side /= np.linalg.norm(side)
        return np.stack([side, np.cross(axis, side), axis])

    def frame(self, blade: int) -> Array:
        """Return the frame of a blade: rows a1 (span), a2 (chord), a3 (thickness).

        Args:
            blade: Number of the blade, from 1.

        Returns:
            Rotation matrix with the right-handed orthonormal axes as rows, shape (3, 3) [-].
        """
        if not 1 <= blade <= self.n_blades:
            raise ModelError(f"blade {blade} does not exist: choose from 1 to {self.n_blades}")
        e1, e2, e3 = self.axes
        azimuth = self.azimuths[blade - 1]
        outwards = cos(azimuth) * e2 - sin(azimuth) * e1
        a1 = cos(self.cone) * outwards + sin(self.cone) * e3
        chord = np.cross(e3, outwards)
        thickness = cos(self.cone) * e3 - sin(self.cone) * outwards
        a2 = cos(self.pitch) * chord + sin(self.pitch) * thickness
        a3 = cos(self.pitch) * thickness - sin(self.pitch) * chord
        return np.stack([a1, a2, a3])

    def directors(self, blade: int) -> Array:
        """Directors of what is fixed to a blade, as columns: along -a2, a1 and a3, shape (3, 3).

        They are those of eqs (30)-(32) of the paper.
        """
        a1, a2, a3 = self.frame(blade)
        return np.column_stack([-a2, a1, a3])

    def point_on_span(self, blade: int, distance: float) -> Array:
        """The point on the pitch axis of a blade at a distance from the rotor centre, (3,) [m]."""
        point: Array = np.asarray(self.centre) + distance * self.frame(blade)[0]
        return point

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

    def check_clearance(self, hub_radius: float, half_width: float) -> None:
        """Raise ModelError if the roots of two neighbouring blades overlap.

        Args:
            hub_radius: Distance of the roots from the rotor centre [m].
            half_width: Half the width of a root [m].
        """
        angles = np.sort(np.mod(self.azimuths, 2 * pi))
        gap = float(np.min(np.diff(angles, append=angles[0] + 2 * pi)))
        if gap < pi and hub_radius * cos(self.cone) * tan(gap / 2) < half_width:
            raise ModelError(
                f"rotor.azimuths = {self.azimuths}: two blades only {np.degrees(gap):.4g} degrees "
                f"apart overlap at a hub radius of {hub_radius:g} m"
            )


def _check_numbers(key: str, values: Iterable[float]) -> tuple[float, ...]:
    """Return finite numbers as a tuple of floats, or raise ModelError with the key."""
    items: list[Any] = list(values) if isinstance(values, Iterable) else [None]
    if not all(isinstance(item, Real) and isfinite(item) for item in items):
        raise ModelError(f"{key} = {values!r}: give finite numbers")
    return tuple(float(item) for item in items)


def _require_positive(key: str, value: float) -> None:
    """Raise ModelError unless the value is a finite number above zero."""
    if not _check_numbers(key, [value])[0] > 0:
        raise ModelError(f"{key} = {value!r}: must be greater than 0")
