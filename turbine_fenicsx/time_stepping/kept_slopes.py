"""Slopes of the loads on the nodes of a reduced body, which serve several tangents.

They turn with the body. With the rotation Q of a copy since K_0 was found, nearly K = Q K_0 Q^T.
"""

from __future__ import annotations

from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

LASTING = 10
"""Number of tangents that they serve; wind and speed of a rotor change meanwhile."""


class KeptSlopes(NamedTuple):
    """Slopes K_0.

    Attributes:
        dt: Step that they belong to [s].
        values: K_0, shape (copies, 3 n, 3 n) [N/m].
        frames: Those of the copies then, shape (copies, 3, 3).
        age: Number of tangents that they have served.
    """

    dt: float
    values: Array
    frames: Array
    age: int = 0

    def serve(self, dt: float) -> bool:
        """Whether they do for one more tangent of a step [s]."""
        return self.age < LASTING and self.dt == dt

    def turn(self, frames: Array) -> Array:
        """K for the frames of the copies now, of the shape of `values`."""
        Q = frames @ self.frames.swapaxes(1, 2)
        copies, k = self.values.shape[:2]
        rows = Q[:, None] @ self.values.reshape(copies, k // 3, 3, k)
        turned = rows.reshape(copies, k * k // 3, 3) @ Q.swapaxes(1, 2)
        return np.asarray(turned.reshape(self.values.shape))

    def save(self, comm: MPI.Intracomm, copies: int) -> RestartData:
        """Everything, of all copies, which rank 0 owns. Collective."""
        data = RestartData({"dt": self.dt, "age": self.age})
        for name, array in (("values", self.values), ("frames", self.frames)):
            whole = array if len(array) else np.zeros((copies, *array.shape[1:]))
            data.arrays[name] = from_rank0(comm, whole)
        return data

    @classmethod
    def restore(cls, data: RestartData, mine: slice) -> KeptSlopes:
        """Slopes that were saved.

        Args:
            mine: Copies of this rank.
        """
        numbers, arrays = data.numbers, data.arrays
        kept = arrays["values"][mine], arrays["frames"][mine]
        return cls(numbers["dt"], *kept, numbers["age"])
