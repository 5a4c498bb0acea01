"""A blade as aerodynamics sees it: chord, twist and polars at stations along the span."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.polar import Polar, PolarTable

STATION_TOLERANCE = 1e-4
"""Readers move stations at the ends of a blade so far inwards: losses are infinite at the very ends
[m]."""


STEEPEST = np.radians(60.0)
"""With more twist a chord does not cross the straight span near its section."""


@dataclass(frozen=True, eq=False)
class AeroBlade:
    """Stations of a blade from root to tip.

    Args:
        hub_radius: Where the blade begins [m].
        tip_radius: Where it ends, measured along the span from the rotor centre [m].
        radius: Stations along the span, rising, within the blade, shape (n,) [m].
        chord: Chords, shape (n,) [m].
        twist: Angles of the chords with the rotor plane at zero pitch, positive towards feather,
            shape (n,) [rad].
        polars: The n polars.
        prebend: How far stations lie downwind of a straight span; None for none, shape (n,) [m].
        reference: Fraction of the chord, from the leading edge, that lies on the bent span, shape
            (n,) or a number [-].
        aerodynamic_centre: Where lift and drag act, in the same way [-].
        lengths: Length of the span whose loads each station stands for, the weights of a
            quadrature; None for what lies between the middles of neighbours, shape (n,) [m].

    Raises:
        ModelError: for stations outside the blade or not in order, chords that are not positive,
            chords or prebend larger than the blade, or numbers that do not fit together.
    """

    hub_radius: float
    tip_radius: float
    radius: Array
    chord: Array
    twist: Array
    polars: Sequence[Polar]
    prebend: Array | None = None
    reference: Array | float = 0.25
    aerodynamic_centre: Array | float = 0.25
    lengths: Array | None = None

    def __post_init__(self) -> None:
        n = len(self.radius)
        for what in ("radius", "chord", "twist", "prebend", "lengths"):
            values = getattr(self, what)
            if what in ("prebend", "lengths") and values is None:
                continue
            if np.shape(values) != (n,) or not np.all(np.isfinite(values)):
                raise ModelError(f"{what} of an aerodynamic blade must be {n} finite numbers")
        for what in ("reference", "aerodynamic_centre"):
            values = np.asarray(getattr(self, what))
            if values.shape not in ((), (n,)) or not np.all(np.isfinite(values)):
                words = what.replace("_", " ")
                raise ModelError(
                    f"{words} of an aerodynamic blade must be a number or {n} of them, got an "
                    f"array of shape {values.shape} or what is not finite"
                )
        if len(self.polars) != n:
            raise ModelError(
                f"an aerodynamic blade needs a polar for each of its {n} stations, got "
                f"{len(self.polars)}"
            )
        if not 0.0 < self.hub_radius < self.tip_radius < np.inf:
            raise ModelError(
                f"an aerodynamic blade must end outside its hub, got radii of {self.hub_radius:g} "
                f"and {self.tip_radius:g} m"
            )
        if n < 2 or not np.all(np.diff(self.radius) > 0.0):
            raise ModelError("an aerodynamic blade needs two or more stations with rising radius")
        ends = self.radius[[0, -1]]
        if not (self.hub_radius <= ends[0] and ends[1] <= self.tip_radius):
            raise ModelError(
                f"stations of an aerodynamic blade must lie between {self.hub_radius:g} and "
                f"{self.tip_radius:g} m, got {ends[0]:g} to {ends[1]:g} m"
            )
        for what in ("chord", "prebend"):
            values = getattr(self, what)
            largest = 0.0 if values is None else np.max(np.abs(values), initial=0.0)
            if largest > self.tip_radius:
                raise ModelError(
                    f"{what} of an aerodynamic blade reaches {largest:g} m, more than its tip "
                    f"radius of {self.tip_radius:g} m"
                )
        if not np.all(self.chord > 0.0):
            k = int(np.argmin(self.chord > 0.0))
            raise ModelError(
                f"chords must be positive, got {self.chord[k]:g} m at {self.radius[k]:g} m"
            )

    @cached_property
    def parts(self) -> Array:
        """Length of the span whose loads each station stands for, shape (n,) [m]."""
        if self.lengths is not None:
            return self.lengths
        middles = 0.5 * (self.radius[1:] + self.radius[:-1])
        return np.diff(np.concatenate([[self.hub_radius], middles, [self.tip_radius]]))

    @cached_property
    def table(self) -> PolarTable:
        """The polars of all stations."""
        return PolarTable(self.polars)


def place_blades(blade: AeroBlade, frames: Array, centre: Array) -> tuple[Array, Array, Array]:
    """Sections of all blades in the initial configuration, at right angles to their bent spans.

    Args:
        frames: Span, way of the rotation and span x way of each blade, shape (B, 3, 3).
        centre: Of the rotor, shape (3,) [m].

    Returns:
        Aerodynamic centres, shape (n, 3) [m]; span, direction of the chord and to the suction side
        as columns, shape (n, 3, 3); lengths of the span by its part along the axis, shape (n,).
    """
    B, n = len(frames), len(blade.radius)
    span, way, normal = np.repeat(frames, n, axis=0).swapaxes(0, 1)
    prebend = np.zeros(n) if blade.prebend is None else blade.prebend
    bend, slope, c, s, back = (
        np.tile(np.broadcast_to(values, (n,)), B)[:, None]
        for values in (
            prebend,
            np.gradient(prebend, blade.radius),
            np.cos(blade.twist),
            np.sin(blade.twist),
            blade.chord * np.subtract(blade.aerodynamic_centre, blade.reference),
        )
    )
    points = centre + np.tile(blade.radius, B)[:, None] * span + bend * normal
    stretch = np.sqrt(1.0 + slope * slope)
    span, normal = (span + slope * normal) / stretch, (normal - slope * span) / stretch
    chordwise, suction = c * way - s * normal, c * normal + s * way
    axes = np.stack([span, chordwise, suction], axis=2)
    return points - back * chordwise, axes, stretch[:, 0]
