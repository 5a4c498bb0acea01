"""The node nearest to a point, among those of all ranks."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array


def nearest_node(comm: MPI.Intracomm, positions: Array, point: npt.ArrayLike) -> int | None:
    """Number of the node nearest to a point, on the rank that owns it; None on all others.

    Args:
        positions: Positions of the nodes that this rank owns, shape (n_owned, 3) [m].
        point: The point, shape (3,) [m].

    Note:
        Collective.
    """
    distance = np.linalg.norm(positions - np.asarray(point, dtype=float), axis=1)
    node = int(np.argmin(distance)) if distance.size else -1
    mine = (float(distance[node]) if distance.size else np.inf, comm.rank)
    return node if comm.allreduce(mine, op=MPI.MINLOC)[1] == comm.rank else None
