"""How loads on sections change with an increment of a step, from loads in the plane of a section.

The loads a (along the chord c, along the suction side s, and about the span t, each for a length L)
depend on p = (V_forward, V_up, theta'). An increment of a step is a translation x and a rotation
phi. It turns the axes by phi/2, and changes the velocity of the aerodynamic centre, whose lever is
l, by x/dt + phi/dt x l + omega x (phi/2 x l). So

    dp = P (x, phi),        dF = L (da_c c + da_s s) + phi/2 x F,
    da = (da/dp) dp,        dM = l x L (da_c c + da_s s) + L da_t t + phi/2 x M.

The wake, and the wind in space, stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from turbine_fenicsx.foundation.rotations import cross_rows, skew_rows
from turbine_fenicsx.foundation.types import Array

PlaneLoads = Callable[[Array], Array]
"""Loads a for p, shapes (3, n)."""

CHANGE = 1e-3
"""Relative changes of p in differences."""


def differentiate(loads: PlaneLoads, p: Array, chord: Array) -> Array:
    """Derivatives da/dp of loads a, shape (n, 3, 3).

    Args:
        p: Where, shape (3, n) [m/s, rad/s].
        chord: Shape (n,) [m].
    """
    W = np.maximum(np.hypot(p[0], p[1]), 1.0)
    a, slopes = loads(p), np.empty((p.shape[1], 3, 3))
    for k, size in enumerate((CHANGE * W, CHANGE * W, CHANGE * W / chord)):
        moved = p.copy()
        moved[k] += size
        slopes[:, :, k] = ((loads(moved) - a) / size).T
    return slopes


def find_changes(
    axes: tuple[Array, Array, Array], V: Array, lever: Array, spins: tuple[Array, Array], dt: float
) -> Array:
    """P, shape (n, 3, 6).

    Args:
        axes: c, s and t, shapes (n, 3).
        V: Flow at the aerodynamic centre, relative to the section, shape (n, 3) [m/s].
        lever: l, shape (n, 3) [m].
        spins: omega, and omega without the rotation of the rotor, shapes (n, 3) [rad/s].
        dt: Step [s].
    """
    chordwise, suction, span = axes
    omega, relative = spins
    P = np.zeros((len(V), 3, 6))
    # V_forward = -V.c, V_up = V.s, theta' = omega.t
    for row, axis, sign in ((0, chordwise, 1.0), (1, suction, -1.0)):
        P[:, row, :3] = sign * axis / dt
        turned = cross_rows(lever, cross_rows(axis, omega)) - cross_rows(axis, V)
        P[:, row, 3:] = sign * (cross_rows(lever, axis) / dt + 0.5 * turned)
    P[:, 2, 3:] = span / dt + 0.5 * cross_rows(span, relative)
    return P


def spread(
    axes: tuple[Array, Array, Array], slopes: Array, lever: Array, loads: tuple[Array, Array]
) -> Array:
    """Derivatives of F and M by x and phi, shape (n, 6, 6).

    Args:
        axes: c, s and t, shapes (n, 3).
        slopes: L da/dp P, shape (n, 3, 6).
        lever: l, shape (n, 3) [m].
        loads: F and M, shapes (n, 3) [N, N m].
    """
    chordwise, suction, span = axes
    E = np.empty((len(lever), 6, 3))
    for k, axis in enumerate((chordwise, suction)):
        E[:, :3, k], E[:, 3:, k] = axis, cross_rows(lever, axis)
    E[:, :3, 2], E[:, 3:, 2] = 0.0, span
    found: Array = E @ slopes
    for k, load in enumerate(loads):
        found[:, 3 * k : 3 * k + 3, 3:] -= 0.5 * skew_rows(load)
    return found
