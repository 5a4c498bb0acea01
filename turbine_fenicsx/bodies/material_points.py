"""Points inside of a flexible body by the nodes around them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array, IntArray


class Surroundings(NamedTuple):
    """The nodes of a cell, and what they weigh at a point of it.

    Attributes:
        nodes: Their numbers, counted over all ranks, shape (k,).
        positions: Their initial positions, shape (k, 3) [m].
        functions: Values of their shape functions, shape (k,).
    """

    nodes: IntArray
    positions: Array
    functions: Array


def find_surroundings(space: Any, point: Array) -> Surroundings | None:
    """The nodes around a point in the initial configuration, equal on all ranks. Collective.

    Args:
        space: Space of the displacement of the body.
        point: Shape (3,) [m].

    Returns:
        None for a point outside the body.
    """
    function, cells = fem.Function(space), _compat.cells_at(space.mesh, point)
    found = _in_cell(function, int(cells[0]), point) if cells.size else None
    # neighbours that share the point agree on its motion
    return next((x for x in space.mesh.comm.allgather(found) if x is not None), None)


def _in_cell(function: fem.Function, cell: int, point: Array) -> Surroundings:
    """The nodes of a cell of this rank; the function is overwritten."""
    space = function.function_space
    nodes = _compat.dofs_of_cells(space)[cell]
    weights = np.zeros(len(nodes))
    for k, node in enumerate(nodes):
        function.x.array[:] = 0.0
        function.x.array[3 * node] = 1.0
        weights[k] = np.ravel(function.eval(point, np.array([cell], dtype=np.int32)))[0]
    numbers = space.dofmap.index_map.local_to_global(nodes.astype(np.int32))
    return Surroundings(numbers, space.tabulate_dof_coordinates()[nodes], weights)
