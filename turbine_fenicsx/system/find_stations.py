"""Stations along a body on a mesh, as close as the nodes of its skin allow."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx.forces.section_loads import StationLine
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.section_transfer import find_flat, share_out


def find_stations(
    model: FlexibleModel, facets: npt.NDArray[np.int32], most: int, axis: int = 0
) -> StationLine:
    """As many equally spaced stations along a body as the nodes of its skin allow. Collective.

    Args:
        model: The body.
        facets: Facets of its skin, indices local to this rank (ghosts allowed).
        most: Largest number of stations.
        axis: The coordinate along which they stand, from the origin.

    Raises:
        ModelError: if the skin allows no two stations.
    """
    areas, X = model.find_areas("stations", facets), model.positions
    along = np.concatenate(model.comm.allgather(X[areas > 0.0, axis]))
    if not len(along):
        raise ModelError(f"the skin of {model.body.name!r} has no nodes")
    for number in range(most, 1, -1):
        places = np.linspace(along.min(), along.max(), number)
        line = StationLine(facets, origin=np.zeros(3), axis=np.eye(3)[axis], stations=places)
        nodes, stations, weights = share_out(line, X, areas, 0)
        sum_nodes = csr_matrix((weights, (stations, nodes)), shape=(number, len(X)))
        counts = np.bincount(stations, minlength=number).astype(float)
        columns = [np.ones((len(X), 1)), X, (X[:, :, None] * X[:, None]).reshape(-1, 9)]
        sums = np.column_stack([counts, sum_nodes @ np.hstack(columns)])
        sums = sum_over_ranks(model.comm, sums)
        centres = sums[:, 2:5] / np.maximum(sums[:, 1:2], np.finfo(float).tiny)
        outer = centres[:, :, None] * centres[:, None] * sums[:, 1, None, None]
        if not np.any(find_flat(sums[:, 0], sums[:, 5:].reshape(-1, 3, 3) - outer)):
            return line
    raise ModelError(f"the skin of {model.body.name!r} has too few nodes for stations")
