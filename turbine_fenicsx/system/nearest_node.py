"""The node of the mesh of any copy of a body that is nearest to a point."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_nodes import BodyNodes


def find_nearest_node(model: BodyNodes, point: npt.ArrayLike) -> tuple[float, csr_matrix]:
    """Distance of the nearest node [m], and its row over the owned nodes. Collective.

    Args:
        point: In the initial configuration, shape (3,) [m].
    """
    index_map = model.space.dofmap.index_map
    X = model.space.tabulate_dof_coordinates()[: index_map.size_local]
    places = [place.frame() for place in model.body.placements]
    x: Array = np.array([t + X @ R.T for R, t in places])
    distances = np.linalg.norm(x - np.asarray(point, dtype=float), axis=2)
    mine = (np.inf, 0, 0)
    if distances.size:
        copy, node = map(int, np.unravel_index(int(np.argmin(distances)), distances.shape))
        mine = (float(distances[copy, node]), copy, node + index_map.local_range[0])
    distance, copy, node = model.comm.allreduce(mine, op=MPI.MIN)
    return distance, model.rows(copy, np.array([node]), np.ones(1))
