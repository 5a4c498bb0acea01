"""Surfaces that move with rigid bodies, for pictures only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.rigid_body import RigidBody
from turbine_fenicsx.rotations import Array


@dataclass(frozen=True, eq=False)
class RigidSurface:
    """A quadrilateral surface that moves with a rigid body.

    Args:
        body: The rigid body.
        points: Initial positions, shape (n, 3) [m].
        quadrilaterals: Corners of the faces, shape (m, 4).
        part: Number that tells the parts apart in the output.
    """

    body: RigidBody
    points: Array
    quadrilaterals: npt.NDArray[np.int64]
    part: int
