"""Lift of attached flow takes time: vorticity that sections shed induces a velocity on them.

The flow at three quarters of the chord c has the part v = W alpha across it (`pitch_rate`). The
vorticity that a section shed while v changed adds a velocity delta across the chord. It turns lift
and drag as well as the angle of attack,

    delta = sum_i (z_i - A_i v),    z_i' = b_i (2 W/c) (A_i v - z_i),

so that a sudden change of v has half of its lift at first, and the rest after tens of chords. A
section that heaves with the reduced frequency k = omega c/(2 W) has the lift of v C(k) then, with

    C(k) = 1 - sum_i A_i i k/(i k + b_i).

Three terms keep within 0.4 % of Theodorsen's function for k from 0.02 to 0.5, and within 0.7 %
everywhere; the two of R. T. Jones, NACA report 681 (1940), A = 0.165, 0.335, b = 0.0455, 0.3, are
2.3 % off. For speeds W that change the states are velocities, as in M. H. Hansen, M. Gaunaa,
H. Aa. Madsen, Risoe-R-1354 (2004). The A_i are those of a flat plate times sigma of `pitch_rate`:
cylinders shed no vorticity that follows their angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.stall import SLOWEST, fade

SHARES = np.array([0.063, 0.267, 0.170])
"""A_i, whose sum is a half [-]."""

RATES = np.array([0.0202, 0.130, 0.482])
"""b_i, for each half chord that the flow moves on [-]."""


@dataclass(frozen=True, eq=False)
class ShedWake:
    """Sections that shed vorticity.

    Args:
        sigma: Lift slope as a part of that of a flat plate, shape (n,) [-].
        chord: c, shape (n,) [m].
    """

    sigma: Array
    chord: Array

    def balance(self, v: Array) -> Array:
        """States after v has been so for long, A_i v, shape (n, 3) [m/s]."""
        return np.asarray((self.sigma * v)[:, None] * SHARES)

    def follow(self, z: Array, v: Array, duration: float, W: Array) -> Array:
        """The states after a time with constant flow, exactly, shape (n, 3) [m/s].

        Args:
            z: States before, shape (n, 3) [m/s].
            v: The flow across the chord at three quarters of it, shape (n,) [m/s].
            duration: Time; infinite at rest [s].
            W: Speed of the flow, shape (n,) [m/s].
        """
        # z_i' = b_i (2 W/c) (A_i v - z_i), exactly
        end = self.balance(v)
        return np.asarray(end + (z - end) * np.exp(-duration * self._find_speeds(W)))

    def find_rate(self, z: Array, v: Array, W: Array) -> Array:
        """z_i', shape (n, 3) [m/s^2]; arguments as of `follow`."""
        return np.asarray(self._find_speeds(W) * (self.balance(v) - z))

    def _find_speeds(self, W: Array) -> Array:
        """b_i 2 W/c, shape (n, 3) [1/s]."""
        return np.asarray((2.0 * np.maximum(W, SLOWEST) / self.chord)[:, None] * RATES)

    def find_velocity(self, z: Array, v: Array, forward: Array) -> Array:
        """The velocity delta that states induce, shape (n,) [m/s].

        It fades where the flow separates, as the delay of the stall does.

        Args:
            z: States now, shape (n, 3) [m/s].
            v: As of `follow`.
            forward: The flow along the chord, shape (n,) [m/s].
        """
        delta = (z - self.balance(v)).sum(axis=1)
        return np.asarray(delta * fade(np.arctan2(v, forward)))
