"""Polars averaged over an amplitude of the angle of attack.

The coefficients C of a table are linear between its angles, so their slopes jump there. A vibration
of the amplitude d sees the mean slope (C(alpha + d) - C(alpha - d))/(2 d) over its way. The mean of
C from alpha - d to alpha + d has this slope.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.polar import Polar

FINE, NEAR = np.radians(0.1), np.radians(40.0)
"""Distance of the angles of an averaged table [rad], up to an angle beyond which they are those
where the slope of the original changes."""


def average_polars(blade: AeroBlade, amplitude: float) -> AeroBlade:
    """A blade whose polars are averaged; itself without an amplitude.

    Args:
        amplitude: d [rad], below 10 degrees.
    """
    if not amplitude:
        return blade
    found = {id(p): p for p in blade.polars}
    averaged = {key: average(polar, amplitude) for key, polar in found.items()}
    return replace(blade, polars=tuple(averaged[id(p)] for p in blade.polars))


def average(polar: Polar, amplitude: float) -> Polar:
    """A polar averaged over an amplitude [rad]."""
    fine = np.arange(-NEAR, NEAR, FINE)
    corners = np.concatenate([polar.angle - amplitude, polar.angle, polar.angle + amplitude, fine])
    ends = polar.angle[[0, -1]]
    inside = (corners > ends[0] + 1e-9) & (corners < ends[1] - 1e-9)
    angle = np.unique(np.concatenate([ends, corners[inside]]))
    above = _integrate(polar, angle + amplitude) - _integrate(polar, angle - amplitude)
    return Polar(polar.name, angle, *(above / (2.0 * amplitude)))


def _integrate(polar: Polar, angle: Array) -> Array:
    """Integrals of C_l, C_d and C_m over a circle and more, to some angles, shape (3, n)."""
    knots = np.concatenate([polar.angle[:-1] + k * 2.0 * np.pi for k in (-1, 0, 1)])
    C = np.tile(polar.coefficients(polar.angle[:-1]), 3)
    widths = np.diff(knots)
    sums = np.cumsum(0.5 * widths * (C[:, 1:] + C[:, :-1]), axis=1)
    sums = np.concatenate([np.zeros((3, 1)), sums], axis=1)
    i = np.clip(np.searchsorted(knots, angle, side="right") - 1, 0, len(widths) - 1)
    x = angle - knots[i]
    slope = (C[:, i + 1] - C[:, i]) / widths[i]
    return np.asarray(sums[:, i] + C[:, i] * x + 0.5 * slope * x * x)
