"""Surfaces that move with rigid bodies, for pictures only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class RigidSurface:
    """A quadrilateral surface that moves with a rigid body.

    Args:
        body: The rigid body.
        points: Initial positions, shape (n, 3) [m].
        quadrilaterals: Corners of the faces, shape (m, 4).
        part: Number that distinguishes the parts in the output.
    """

    body: RigidBody
    points: Array
    quadrilaterals: npt.NDArray[np.int64]
    part: int


def inertia_box(body: RigidBody, part: int) -> RigidSurface:
    """The homogeneous box that has the mass and the Euler values of a rigid body.

    A box of half lengths a_i has the Euler values m a_i^2/3. Where one is zero, so that there is no
    thickness, the box gets a hundredth of its length.

    Args:
        body: The rigid body.
        part: Number of the part.
    """
    half = np.sqrt(3.0 * np.asarray(body.euler, dtype=float) / body.mass)
    half = np.maximum(half, 0.01 * half.max())
    corners = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    directors = np.asarray(body.directors, dtype=float)
    points = np.asarray(body.position, dtype=float) + (corners * half) @ directors.T
    return RigidSurface(body, points, np.array(faces, dtype=np.int64), part)
