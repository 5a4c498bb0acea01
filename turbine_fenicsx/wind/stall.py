"""Dynamic stall after Oeye: the separation of the flow at the trailing edge follows with a delay.

The lift of an aerofoil lies between that of attached and that of fully separated flow,

    C_l = f C_l,inv(alpha) + (1 - f) C_l,sep(alpha),    C_l,inv = C_l,alpha sin(alpha - alpha_0),

where f is the attached part of the chord. In balance it is that of the polar, which Kirchhoff's
flow past a plate gives,

    C_l,st = C_l,inv ((1 + s)/2)^2,    C_l,sep = C_l,inv (1 + 3 s)/(4 + 4 s),    s = sqrt(f_st),

or f_st = 0 and C_l,sep = C_l,st below a quarter of C_l,inv. Else it follows,

    f' = (f_st - f)/tau,    tau = T c/W,    T = 4.

S. Oeye, "Dynamic stall, simulated as time lag of separation", Proc. 4th IEA Symposium on the
Aerodynamics of Wind Turbines, 1991; separated lift as M. H. Hansen, M. Gaunaa, H. Aa. Madsen,
Risoe-R-1354 (2004), with a sine for the angle so that all angles have a lift.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.argument_checks import check_positive
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.polar import (
    SMALL_ANGLE,
    AngleTable,
    PolarTable,
    find_lift_slope,
    measure_from,
)

FULL, NONE = np.radians(30.0), np.radians(60.0)
"""The delay acts in full up to the first of these angles around the angle without lift, and no
longer from the second on, where the flow is that past a bluff body [rad]."""

SLOWEST = 1e-6
"""Slower flow takes as long as this one [m/s]."""


@dataclass(frozen=True)
class OeyeStall:
    """How long separation takes.

    Args:
        lag: T, the time constant as a number of chords that the flow moves on [-].
    """

    lag: float = 4.0

    def __post_init__(self) -> None:
        check_positive("lag of the stall", self.lag)

    def follow(self, f: Array, f_st: Array, duration: float, chord: Array, W: Array) -> Array:
        """The attached part after a time with constant flow, exactly.

        Args:
            f: The attached part before, shape (n,) [-].
            f_st: That of the polar, shape (n,) [-].
            duration: Time; infinite at rest [s].
            chord: c, shape (n,) [m].
            W: Speed of the flow, shape (n,) [m/s].
        """
        # f' = (f_st - f)/tau, exactly
        tau = self._find_tau(chord, W)
        return np.asarray(f_st + (f - f_st) * np.exp(-duration / tau))

    def find_rate(self, f: Array, f_st: Array, chord: Array, W: Array) -> Array:
        """f', shape (n,) [1/s]; arguments as of `follow`."""
        return np.asarray((f_st - f) / self._find_tau(chord, W))

    def _find_tau(self, chord: Array, W: Array) -> Array:
        """tau, shape (n,) [s]."""
        return np.asarray(self.lag * chord / np.maximum(W, SLOWEST))


def tabulate_separation(table: PolarTable, blades: int = 1) -> AngleTable:
    """C_l, C_d, C_m, f_st and C_l,inv - C_l,sep of the stations of blades."""
    lifts = table.values[:, :, 0]
    separated = np.stack([np.stack(separate(table.angles, C_l), axis=1) for C_l in lifts])
    return table.tabulate(np.concatenate([table.values, separated], axis=2), blades)


def separate(angle: Array, lift: Array) -> tuple[Array, Array]:
    """The attached part of the chord that explains a polar.

    Args:
        angle: Angles of attack, rising from -pi to pi, shape (m,) [rad].
        lift: C_l,st, shape (m,) [-].

    Returns:
        f_st and C_l,inv - C_l,sep; 1 and 0 for a body without lift, such as a cylinder.
    """
    found = find_lift_slope(angle, lift)
    if found is None:
        return np.ones_like(angle), np.zeros_like(angle)
    alpha_0, C_l_alpha = found
    x = measure_from(alpha_0, angle)
    inviscid = C_l_alpha * np.sin(x)
    ahead = (np.abs(x) < 0.5 * np.pi) & (np.abs(inviscid) > 1e-9)
    ratio = np.where(ahead, lift / np.where(ahead, inviscid, 1.0), 0.0)
    ratio[np.abs(x) <= SMALL_ANGLE] = 1.0
    # Kirchhoff: C_l,st = C_l,inv ((1 + s)/2)^2, and the separated lift that follows
    root = np.clip(2.0 * np.sqrt(np.maximum(ratio, 0.0)) - 1.0, 0.0, 1.0)
    partly = inviscid * (3.0 + root) / (4.0 + 4.0 * root)
    difference = np.where(root > 0.0, partly, inviscid - lift)
    return root * root, difference * fade(x)


def fade(x: Array) -> Array:
    """Part of a delay that acts at angles from that without lift on, 0 to 1."""
    return np.asarray(np.clip((NONE - np.abs(x)) / (NONE - FULL), 0.0, 1.0))
