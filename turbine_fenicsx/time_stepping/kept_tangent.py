"""The tangent of an earlier iteration for the body where it is now, perhaps steps later.

The tangent of a copy turns with its vectors. With the rotation Q of the copy since A_0 was
made, nearly

    A = Q A_0 Q^T,        J = J_0 Q^T,        J_m = J_m0 Q^T.

But stiff walls bend without stretch, and J says how. A small error of J in J_m^T D c, with D of
`ReducedStep`, is multiplied by their stiffness. So strain coordinates c_e are unknowns too, as in
mixed methods, and the same J stands in both linear equations,

    A ddz = -R - (J_m0 - J_m)^T D (c - c_e),        c_e <- c + J ddz.

With c_e = c this is R = 0. (Magisano, Leonetti and Garcea 2017 take c_e with a new tangent.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.frames import polar_rotation


class KeptTangent(NamedTuple):
    """Parts of A_0, of all copies.

    Attributes:
        dt: Step that it belongs to [s].
        J: J_0 at its end, shape (copies, r, 3 n).
        loaded: D J_m0, shape (copies, r, 3 n).
        ends: Vectors z at its start and end, shape (2, copies, n, 3).
        frames: Those of the copies at its end, shape (copies, 3, 3).
    """

    dt: float
    J: Array
    loaded: Array
    ends: Array
    frames: Array

    def find_turn(self, z: Array) -> Array:
        """Q for vectors z now, shape (copies, 3, 3)."""
        return np.asarray(find_frames(z) @ self.frames.swapaxes(1, 2))

    def find_forces(self, Q: Array, lag: Array) -> Array:
        """J_m^T D (c - c_e) for c - c_e of shape (copies, r), shape (copies, n, 3)."""
        single = lag[:, None].astype(self.loaded.dtype)
        forces = (single @ self.loaded).reshape(self.ends.shape[1:])
        return np.asarray(forces @ Q.swapaxes(1, 2))


class ExpectedStrain(NamedTuple):
    """The change of c in a step as it is expected near increments dz.

    Attributes:
        dz: Shape (copies, n, 3).
        change: Change of c there, shape (copies, r).
        J: Shape (copies, r, 3 n).
        Q: Rotation of J, shape (copies, 3, 3).
    """

    dz: Array
    change: Array
    J: Array
    Q: Array

    def at(self, dz: Array) -> Array:
        """Change of c expected at other increments, shape (copies, r)."""
        moved = ((dz - self.dz) @ self.Q).reshape(len(dz), self.J.shape[2], 1)
        found: Array = self.change + (self.J @ moved.astype(self.J.dtype))[..., 0]
        return found


def find_frames(z: Array) -> Array:
    """Rotation of the first interface of each copy, shape (copies, 3, 3)."""
    return polar_rotation(z[:, 1:4].transpose(2, 1, 0)).transpose(2, 0, 1)
