"""Joint coordinates: angles and displacements that are coordinates of the system, eqs (15)-(18).

An angle Theta is tied to the functions c and s of the directors that equal its cosine and sine
(`augmented_angle`). A displacement is tied to the quadratic function f of the coordinates that
equals it, Phi = Theta - f, whose discrete gradient is exact at the midpoint.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.quadratic import AffineVector, Quadratic, dot
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import AngleForm, AngleTerms


class Angle(NamedTuple):
    """An angle by its cosine and sine as functions of the coordinates [rad]."""

    cosine: Quadratic
    sine: Quadratic


class Displacement(NamedTuple):
    """A displacement as a function of the coordinates [m]."""

    value: Quadratic


JointCoordinate = Angle | Displacement


def angle_between(t1_a: AffineVector, t2_a: AffineVector, t1_b: AffineVector) -> Angle:
    """Angle from t1_a to t1_b in the plane of the orthonormal t1_a and t2_a, eq. (16)."""
    return Angle(dot(t1_a, t1_b), dot(t2_a, t1_b))


def augmentation(form: AngleForm, is_angle: npt.NDArray[np.bool_]) -> AngleForm:
    """Constraint terms of all joint coordinates.

    Args:
        is_angle: Which coordinates are angles, shape (n_T,); the others are displacements, for
            which c is the function f and s does not count.
    """
    if np.all(is_angle):
        return form

    def mixed(T0: Array, T1: Array, c0: Array, c1: Array, s0: Array, s1: Array) -> AngleTerms:
        angle, length = form(T0, T1, c0, c1, s0, s1), _length(T1, c1)
        return AngleTerms(*(np.where(is_angle, a, b) for a, b in zip(angle, length, strict=True)))

    return mixed


def _length(T1: Array, f1: Array) -> AngleTerms:
    """Phi = Theta - f."""
    one, zero = np.ones_like(T1), np.zeros_like(T1)
    return AngleTerms(
        Phi=T1 - f1,
        Phi_T=one,
        Phi_c=-one,
        Phi_s=zero,
        g_c=-one,
        g_s=zero,
        g_T=one,
        g_c_T=zero,
        g_s_T=zero,
        g_T_T=zero,
        g_T_c=zero,
        g_T_s=zero,
    )
