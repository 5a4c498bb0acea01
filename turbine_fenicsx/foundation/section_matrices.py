"""6 x 6 matrices of sections from their centres, principal axes and stiffnesses.

Strains at a point (x, y) of a section follow from those at its origin, T e, with

    gamma_x - y kappa_z,    gamma_y + x kappa_z,    eps + y kappa_x - x kappa_y,

and in axes that are turned by an angle about z, R T e. So a stiffness K there is T^T R^T K R T
about the origin.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array


def move_stiffness(K: Array, x: Array, y: Array, angle: Array) -> Array:
    """Stiffness about the origin of sections.

    Args:
        K: About a point, in turned axes, shape (m, 6, 6).
        x: Place of the point in the axes of the section, shape (m,) [m].
        y: The other coordinate.
        angle: By which the axes of K are turned about z [rad].

    Returns:
        Shape (m, 6, 6).
    """
    to_point = find_to_point(x, y, angle)
    found: Array = to_point.swapaxes(1, 2) @ K @ to_point
    return found


def find_to_point(x: Array, y: Array, angle: Array) -> Array:
    """R T, which turns strains at the origin into those at a point, in turned axes.

    Args:
        x: Place of the point, shape (m,) [m].
        y: The other coordinate.
        angle: By which the axes are turned about z [rad].

    Returns:
        Shape (m, 6, 6).
    """
    T = np.tile(np.eye(6), (len(x), 1, 1))
    T[:, 0, 5], T[:, 1, 5], T[:, 2, 3], T[:, 2, 4] = -y, x, y, -x
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros_like(T)
    for first in (0, 3):
        R[:, first, first], R[:, first, first + 1] = c, s
        R[:, first + 1, first], R[:, first + 1, first + 1] = -s, c
        R[:, first + 2, first + 2] = 1.0
    found: Array = R @ T
    return found


def place_inertia(mass: Array, centre: Array, squares: Array, angle: Array) -> Array:
    """Mass matrices about the origin of sections, shape (m, 6, 6).

    Args:
        mass: Shape (m,) [kg/m].
        centre: Centre of mass in the axes of the section, shape (m, 2) [m].
        squares: Squared radii of gyration about axes x and y through that centre, turned by the
            angle, shape (m, 2) [m^2].
        angle: Of these axes about z, shape (m,) [rad].
    """
    c, s = np.cos(angle), np.sin(angle)
    (x, y), (along_y, along_x) = centre.T, mass * squares.T  # int rho y^2, x^2
    E_xx = c * c * along_x + s * s * along_y + mass * x * x
    E_yy = s * s * along_x + c * c * along_y + mass * y * y
    E_xy = c * s * (along_x - along_y) + mass * x * y
    return make_inertia(mass, centre, np.column_stack([E_xx, E_yy, E_xy]))


def make_inertia(mass: Array, centre: Array, seconds: Array) -> Array:
    """Mass matrices about the origin of sections, shape (m, 6, 6).

    Args:
        mass: Shape (m,) [kg/m].
        centre: Centre of mass, shape (m, 2) [m].
        seconds: Integrals of rho x^2, rho y^2 and rho x y, shape (m, 3) [kg m].
    """
    (x, y), (E_xx, E_yy, E_xy) = centre.T, seconds.T
    M = np.zeros((len(mass), 6, 6))
    M[:, 0, 0] = M[:, 1, 1] = M[:, 2, 2] = mass
    M[:, 0, 5] = M[:, 5, 0] = -mass * y
    M[:, 1, 5] = M[:, 5, 1] = mass * x
    M[:, 2, 3] = M[:, 3, 2] = mass * y
    M[:, 2, 4] = M[:, 4, 2] = -mass * x
    M[:, 3, 3], M[:, 4, 4], M[:, 5, 5] = E_yy, E_xx, E_xx + E_yy
    M[:, 3, 4] = M[:, 4, 3] = -E_xy
    return M


def interpolate_matrices(s: Array, stations: Array, matrices: Array) -> Array:
    """Matrices at other stations, straight between their own, shape (k, 6, 6)."""
    flat = matrices.reshape(len(stations), -1).T
    columns = [np.interp(s, stations, column) for column in flat]
    return np.column_stack(columns).reshape(len(s), 6, 6)
