"""Principal moments, principal axes and Euler values of a tensor of inertia."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

ROUND_OFF = 1e-10
"""Relative errors of a tensor that come from adding up and rotating it, not from a slip."""


def principal_inertia(name: str, inertia: npt.ArrayLike) -> tuple[Array, Array]:
    """Euler values and principal axes of a tensor of inertia.

    Args:
        inertia: J [kg m^2], principal moments of shape (3,), or a tensor of shape (3, 3).

    Returns:
        The Euler values E = tr(J)/2 - J of the principal moments, shape (3,), and the principal
        axes as columns, a rotation matrix of shape (3, 3).
    """
    what = f"inertia of rigid body {name!r}"
    words = "three principal moments, or a tensor of shape (3, 3)"
    if np.asarray(inertia, dtype=object).ndim < 2:
        moments, axes = check_array(what, inertia, (3,), words), np.eye(3)
    else:
        J = check_array(what, inertia, (3, 3), words)
        if not np.allclose(J, J.T, rtol=0.0, atol=ROUND_OFF * np.max(np.abs(J))):
            raise ModelError(f"{what} must be symmetric, got {J.tolist()}")
        moments, axes = np.diag(J), np.eye(3)
        if np.count_nonzero(J - np.diag(moments)):
            moments, axes = np.linalg.eigh(J)
            axes[:, 2] *= np.sign(np.linalg.det(axes))
    listed = ", ".join(f"{moment:g}" for moment in moments)
    if not np.all(moments > ROUND_OFF * np.max(moments)):
        raise ModelError(f"principal moments of {what} must be positive, got {listed} kg m^2")
    euler: Array = 0.5 * moments.sum() - moments
    if np.any(euler < -ROUND_OFF * np.max(moments)):
        raise ModelError(
            f"{what} belongs to no mass: none of the principal moments may be larger than the sum "
            f"of the other two, got {listed} kg m^2"
        )
    return np.maximum(euler, 0.0), axes
