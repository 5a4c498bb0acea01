"""Nodes that this rank owns, of some cells or facets."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import IntArray


def nodes_of_cells(space: Any, cells: npt.ArrayLike) -> IntArray:
    """Owned nodes in some local cells, sorted, shape (n,).

    Args:
        cells: Local cells.
    """
    dofs = _compat.dofs_of_cells(space)[np.asarray(cells, dtype=np.int64)]
    return _keep_owned(space, dofs)


def nodes_of_facets(space: Any, facets: npt.NDArray[np.int32]) -> IntArray:
    """Owned nodes on some local facets, sorted, shape (n,). Collective.

    Args:
        facets: Local facets, also those whose cells other ranks own.
    """
    space.mesh.topology.create_connectivity(2, 3)
    return _keep_owned(space, fem.locate_dofs_topological(space, 2, facets))


def _keep_owned(space: Any, nodes: Any) -> IntArray:
    """Those of some nodes that this rank owns, each once."""
    owned: IntArray = np.unique(nodes[nodes < space.dofmap.index_map.size_local]).astype(np.int64)
    return owned
