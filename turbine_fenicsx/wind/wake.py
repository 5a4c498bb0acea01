"""Dynamic inflow after Oeye: the wake follows the loads with two time constants.

    y + tau_1 y' = w_qs + 0.6 tau_1 w_qs',    w + tau_2 w' = y,

    tau_1 = 1.1/(1 - 1.3 a) R/V,    tau_2 = (0.39 - 0.26 (r/R)^2) tau_1,

with the induced velocity w_qs of a wake in balance with the loads. A step updates both exactly for
w_qs constant over it. With z = y - 0.6 w_qs the derivative of w_qs goes out,

    tau_1 z' = 0.4 w_qs - z,    tau_2 w' = z + 0.6 w_qs - w.

H. Snel and J. G. Schepers (eds.), Joint Investigation of Dynamic Inflow
Effects, ECN-C--94-107 (1995).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

SHARE = 0.6
LARGEST_INDUCTION = 0.5
"""The time constants were fitted up to this a."""


@dataclass(frozen=True, eq=False)
class Wake:
    """Induced velocities at all sections.

    Attributes:
        balanced: w_qs of the last step, shape (n, 2) [m/s].
        between: y, shape (n, 2) [m/s].
        velocity: w, shape (n, 2) [m/s].
    """

    balanced: Array
    between: Array
    velocity: Array

    @classmethod
    def in_balance(cls, w: Array) -> Wake:
        """The wake of loads that have been so for long."""
        return cls(w, w, w)

    def advance(self, w_qs: Array, dt: float, a: Array, radius: Array, R: float, V: float) -> Wake:
        """The wake a step later.

        Args:
            w_qs: Induced velocities in balance with the loads, shape (n, 2) [m/s].
            dt: Step [s].
            a: Axial induction, shape (n,) [-].
            radius: r of the sections, shape (n,) [m].
            R: Radius of the rotor [m].
            V: Speed of the wind [m/s].
        """
        # exact steps of both equations in the head of this file
        tau_1, tau_2 = find_time_constants(a, radius, R, V)
        target = w_qs + SHARE * tau_1[:, None] * (w_qs - self.balanced) / dt
        y = target + np.exp(-dt / tau_1)[:, None] * (self.between - target)
        w = y + np.exp(-dt / tau_2)[:, None] * (self.velocity - y)
        return Wake(w_qs, y, w)

    def save(self) -> RestartData:
        """All three velocities."""
        return RestartData(arrays={name: values.copy() for name, values in vars(self).items()})

    @classmethod
    def restore(cls, data: RestartData) -> Wake:
        """The wake that was saved."""
        return cls(*(data.arrays[name].copy() for name in ("balanced", "between", "velocity")))


def find_time_constants(a: Array, radius: Array, R: float, V: float) -> tuple[Array, Array]:
    """tau_1 and tau_2, shapes (n,) [s]; arguments as of `Wake.advance`."""
    tau_1 = 1.1 / (1.0 - 1.3 * np.clip(a, 0.0, LARGEST_INDUCTION)) * R / max(V, 1e-3)
    return tau_1, (0.39 - 0.26 * np.minimum(radius / R, 1.0) ** 2) * tau_1


def find_rates(z: Array, w: Array, w_qs: Array, taus: tuple[Array, Array]) -> tuple[Array, Array]:
    """Z' and w', shapes (n, 2) [m/s^2].

    Args:
        z: y - 0.6 w_qs, shape (n, 2) [m/s].
        w: Induced velocities, shape (n, 2) [m/s].
        w_qs: Those in balance with the loads, shape (n, 2) [m/s].
        taus: Time constants, shapes (n,) [s].
    """
    tau_1, tau_2 = (tau[:, None] for tau in taus)
    return ((1.0 - SHARE) * w_qs - z) / tau_1, (z + SHARE * w_qs - w) / tau_2
