"""Where a body, or a copy of it, stands."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a copy of a body stands, x = position + rotation X.

    Args:
        position: Shape (3,) [m].
        rotation: Rotation matrix, shape (3, 3).

    Raises:
        ModelError: for other shapes, or a matrix that is not a rotation.
    """

    _: KW_ONLY
    position: npt.ArrayLike = (0.0, 0.0, 0.0)
    rotation: npt.ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def __post_init__(self) -> None:
        check_vectors("a placement", position=self.position)
        R = check_array("rotation of a placement", self.rotation, (3, 3), "a rotation matrix")
        if not np.allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-12) or np.linalg.det(R) < 0.0:
            raise ModelError(f"rotation of a placement must be a rotation, got {self.rotation!r}")

    def frame(self) -> tuple[Array, Array]:
        """Rotation and position as arrays, shapes (3, 3) and (3,) [m]."""
        return np.asarray(self.rotation, dtype=float), np.asarray(self.position, dtype=float)

    def place(self, vectors: Array, is_point: Array) -> Array:
        """Vectors of the copy, shape (n, 3).

        Args:
            vectors: Those of the mesh, shape (n, 3).
            is_point: Which of them are points, 1 or 0, shape (n,).
        """
        R, t = self.frame()
        placed: Array = vectors @ R.T + is_point[:, None] * t
        return placed
