"""Equally spaced load stations of a body on a mesh, three rows of skin nodes or more for each.

With more of them the loads of a station rest on a single row of nodes, and thin walls buckle under
it as under no pressure.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.section_loads import StationLine
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.mesh_areas import find_areas
from turbine_fenicsx.system.section_transfer import find_flat, share_out, sum_stations


def find_stations(
    model: FlexibleModel, facets: npt.NDArray[np.int32], most: int, axis: int = 0
) -> StationLine:
    """Equally spaced stations along a body, each with rows of nodes around it. Collective.

    Args:
        facets: Facets of its skin, indices local to this rank (ghosts allowed).
        most: Maximum number of stations.
        axis: The coordinate along which they stand, from the origin.
    """
    areas, X = find_areas(model.space, "stations", facets), model.positions
    along = np.concatenate(model.comm.allgather(X[areas > 0.0, axis]))
    if not len(along):
        raise ModelError(f"the skin of {model.body.name!r} has no nodes")

    def place(number: int) -> StationLine:
        places = np.linspace(along.min(), along.max(), number)
        return StationLine(facets, origin=np.zeros(3), axis=np.eye(3)[axis], stations=places)

    for closest in range(3 * most, 1, -1):
        sums = sum_stations(model.comm, closest, X, share_out(place(closest), X, areas))
        if not np.any(find_flat(sums.counts, sums.moments)):
            return place(min(most, max(2, closest // 3 + 1)))
    raise ModelError(f"the skin of {model.body.name!r} has too few nodes for stations")
