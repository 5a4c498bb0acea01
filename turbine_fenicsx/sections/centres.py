"""Centres and principal axes of a section, from its compliance."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array


def find_tension_centre(S: Array) -> Array:
    """Point where a force along z does not bend the section, shape (2,) [m].

    A force N at x, y has the moments y N and -x N.

    Args:
        S: Compliance, shape (6, 6).
    """
    # S_4,3 + S_44 y - S_45 x = 0,    S_53 + S_54 y - S_55 x = 0
    y, minus_x = np.linalg.solve(S[3:5, 3:5], -S[3:5, 2])
    return np.array([-float(minus_x), float(y)])


def find_shear_centre(S: Array) -> Array:
    """Point where forces across do not twist the section that they act on, shape (2,) [m].

    Forces F_x, F_y at x, y have the moment x F_y - y F_x.
    """
    return np.asarray(np.array([-S[5, 1], S[5, 0]]) / S[5, 5])


def find_principal_axes(S: Array) -> tuple[Array, float]:
    """Bending stiffnesses about the principal axes, and the direction of these.

    They are those of a section that is free to stretch and twist, so they do not depend on the
    origin.

    Returns:
        Smaller and larger stiffness [N m^2], and the angle from x to the axis of the smaller one,
        from 0 to pi [rad].
    """
    stiffness, axes = np.linalg.eigh(np.linalg.inv(S[3:5, 3:5]))
    x, y = axes[:, 0]
    return stiffness, float(np.arctan2(y, x) % np.pi)
