"""Which rank gets which cells of a mesh that falls into equal components, such as three blades.

Equal are components with as many cells. All are cut alike, and a rank gets the same part of each.
So its parts are congruent where the components are, and what is found for one of them, such as a
factor, serves for all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx.foundation.types import Array, IntArray

THINNEST = 6
"""Minimum number of layers of cells of each equal part on a rank, and never fewer than there are
ranks. With more ranks the interfaces that all of them solve for grow, and the parts between become
thinner."""

UNEVEN = 1.1
"""Maximum ratio of the cells of the largest part to their mean."""


def share_equal_components(points: Array, cells: IntArray, ranks: int) -> NDArray[np.int32] | None:
    """The rank of each cell; None if the mesh is not of equal components, or these too short.

    A component is cut into slabs: layers of cells, counted from one of its ends, are never cut, so
    that ranks meet in whole cross-sections of a slender body.

    Args:
        points: Coordinates of the nodes, shape (n, 3) [m].
        cells: Nodes of each cell, shape (m, nodes per cell).
        ranks: Number of ranks.
    """
    found = _find_layers(points, cells)
    if found is None:
        return None
    component, layers = found
    owners = np.empty(len(cells), dtype=np.int32)
    for k in range(component.max() + 1):
        slabs = _cut(layers[component == k], ranks)
        if slabs is None:
            return None
        owners[component == k] = slabs
    return owners


def _find_layers(points: Array, cells: IntArray) -> tuple[IntArray, IntArray] | None:
    """The component of each cell and its layer there; None if components are not equal."""
    starts = np.arange(0, cells.size + 1, cells.shape[1])
    nodes_of = csr_matrix((np.ones(cells.size, np.int8), cells.ravel(), starts))
    cells_of = nodes_of.T.tocsr()
    # as a graph: each cell is tied to its nodes by way of its first one
    ties = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    graph = csr_matrix((np.ones(cells.size, np.int8), ties), (len(points),) * 2)
    component = np.unique(
        connected_components(graph, directed=False)[1][cells[:, 0]], return_inverse=True
    )[1]
    sizes = np.bincount(component)
    if sizes.size == 1 or np.any(sizes != sizes[0]):
        return None
    return component, _number_layers(points[cells].mean(axis=1), component, nodes_of, cells_of)


def list_ranks(
    cells: IntArray, owners: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Ranks of each cell and of its neighbours, its own first, and where those of each start.

    Args:
        cells: Nodes of each cell, shape (m, nodes per cell).
        owners: Rank of each cell, shape (m,).
    """
    (m, width), n = cells.shape, np.max(cells, initial=0) + 1
    nodes_of = csr_matrix((np.ones(m * width), cells.ravel(), np.arange(m + 1) * width), (m, n))
    is_owner = csr_matrix((np.ones(m), owners, np.arange(m + 1)), (m, owners.max(initial=0) + 1))
    near = nodes_of @ (nodes_of.T @ is_owner)
    row = np.repeat(np.arange(m), np.diff(near.indptr))
    own_first = np.lexsort((near.indices != owners[row], row))
    return near.indices[own_first].astype(np.int32), near.indptr.astype(np.int32)


def _number_layers(
    centres: Array, component: IntArray, nodes_of: csr_matrix, cells_of: csr_matrix
) -> IntArray:
    """The layer of each cell, counted from an end of its component.

    The last cells to be reached from the one farthest from the middle are the whole other end.
    """
    by_component = np.argsort(component, kind="stable")
    parts = np.split(by_component, np.cumsum(np.bincount(component))[:-1])
    outermost = [_find_outermost(centres, part) for part in parts]
    steps = _count_steps(np.array(outermost), nodes_of, cells_of)
    ends = [part[steps[part] == steps[part].max()] for part in parts]
    return _count_steps(np.concatenate(ends), nodes_of, cells_of)


def _find_outermost(centres: Array, part: IntArray) -> int:
    """The cell of a component farthest from its middle; of equals that nearest to all components.

    Without the second rule round-off would decide which end of a prismatic component comes first.
    """
    distance = np.linalg.norm(centres[part] - centres[part].mean(axis=0), axis=1)
    equals = part[distance >= (1.0 - 1e-6) * distance.max()]
    inwards = np.linalg.norm(centres[equals] - centres.mean(axis=0), axis=1)
    return int(equals[np.argmin(inwards)])


def _count_steps(first: IntArray, nodes_of: csr_matrix, cells_of: csr_matrix) -> IntArray:
    """Steps from cell to cell with a common node from the first ones to each cell."""
    steps = np.full(nodes_of.shape[0], -1)
    steps[first] = 0
    reached = first
    while reached.size:
        near = np.unique(cells_of[np.unique(nodes_of[reached].indices)].indices)
        near = near[steps[near] < 0]
        steps[near] = steps[reached[0]] + 1
        reached = near
    return steps


def _cut(layers: IntArray, ranks: int) -> IntArray | None:
    """The rank of each cell of a component by its layer, None where that would be uneven."""
    ends = np.cumsum(np.bincount(layers))
    cuts = np.searchsorted((ends[:-1] + ends[1:]) / 2, ends[-1] * np.arange(1, ranks) / ranks)
    bounds = np.concatenate([[-1], cuts, [ends.size - 1]])
    owners: IntArray = np.searchsorted(cuts, layers, side="left")
    largest = np.max(np.bincount(owners, minlength=ranks))
    if np.min(np.diff(bounds)) < max(THINNEST, ranks) or largest * ranks > UNEVEN * layers.size:
        return None
    return owners
