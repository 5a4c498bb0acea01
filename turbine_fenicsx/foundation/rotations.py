"""Small helpers for directions and rotation matrices (numpy, no state)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])

E1, E2, E3 = np.eye(3)
"""Inertial basis; e2 is vertical, e3 points downwind, along the shaft if it is not tilted."""


def unit(vector: npt.ArrayLike) -> Array:
    """Unit vector along ``vector``.

    Args:
        vector: Shape (3,), not zero.

    Returns:
        Shape (3,).
    """
    v = np.asarray(vector, dtype=float)
    if v.shape != (3,) or not 0.0 < np.linalg.norm(v) < np.inf:
        raise ModelError(f"a direction needs three numbers, not all zero; got {vector!r}")
    direction: Array = v / np.linalg.norm(v)
    return direction


def rotation_about(axis: npt.ArrayLike, angle: float) -> Array:
    """Rotation matrix exp(angle skew(axis)) (Rodrigues' formula).

    Args:
        axis: Direction, shape (3,).
        angle: Angle [rad].

    Returns:
        Shape (3, 3), columns are the images of e1, e2, e3.
    """
    n = unit(axis)
    K = skew(n)
    R: Array = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)
    return R


def skew(w: npt.ArrayLike) -> Array:
    """Return the matrix of the cross product with w, (3, 3): its product with v is w x v."""
    x, y, z = np.asarray(w, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def skew_rows(a: Array) -> Array:
    """Matrices of the cross products with some vectors, shape (n, 3, 3) for (n, 3)."""
    found = np.zeros((len(a), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[:, k, j], found[:, j, k] = a[:, i], -a[:, i]
    return found


def cross_rows(a: Array, b: Array) -> Array:
    """Cross products of rows, both of shape (n, 3); quicker for few rows than numpy's."""
    found = a.take(_NEXT, axis=1) * b.take(_LAST, axis=1)
    found -= a.take(_LAST, axis=1) * b.take(_NEXT, axis=1)
    return found


def nearest_rotation(B: Array) -> Array:
    """Rotation R that is nearest to a matrix: the largest trace of R^T B.

    Args:
        B: Shape (..., 3, 3).

    Returns:
        Shape (..., 3, 3), nan where B is not finite, as in an attempt of a step that diverges.
    """
    finite = np.isfinite(B).all(axis=(-2, -1))[..., None, None]
    every = finite.all()
    U, _, V_T = np.linalg.svd(B if every else np.where(finite, B, 0.0))
    U[..., 2] *= np.linalg.det(U @ V_T)[..., None]
    R = U @ V_T
    return np.asarray(R if every else np.where(finite, R, np.nan))


def frame_with_axis(axis: npt.ArrayLike, towards: npt.ArrayLike | None = None) -> Array:
    """Right-handed frame (t1, t2, n) with n along ``axis``.

    Args:
        axis: Direction of n, shape (3,).
        towards: Direction that t1 points to as far as it is normal to n; any if None.

    Returns:
        Shape (3, 3), columns t1, t2, n.
    """
    n = unit(axis)
    hint = np.eye(3)[np.argmin(np.abs(n))] if towards is None else np.asarray(towards, dtype=float)
    t1 = hint - (hint @ n) * n
    if np.linalg.norm(t1) < 1e-9 * np.linalg.norm(hint):
        raise ModelError(f"direction {towards!r} is parallel to the axis {axis!r}")
    t1 = unit(t1)
    return np.column_stack([t1, np.cross(n, t1), n])
