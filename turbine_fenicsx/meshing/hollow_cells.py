"""Cells of a hollow blade from grids of node numbers, with what each is part of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import reference_cell

HEXAHEDRON = reference_cell("hexahedron", 2)
_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


@dataclass(frozen=True)
class Cells:
    """Cells and what they are part of; the attributes are those of `HollowBlock`."""

    cells: IntArray
    part: IntArray
    span: Array
    arc: Array
    wanted: Array
    thickness: Array

    @classmethod
    def join(cls, groups: Sequence[Cells]) -> Cells:
        """All cells of some groups, one group after the other."""
        return cls(
            *(np.concatenate([getattr(g, field.name) for g in groups]) for field in fields(cls))
        )


def cells_of_grid(number: IntArray) -> IntArray:
    """Quadratic hexahedra on a grid of nodes.

    Args:
        number: Nodes along, around and through, shape (2 m + 1, 2 n + 1, 3).

    Returns:
        Nodes of the cells in gmsh's order, shape (m, n, 27).
    """
    i, j, k = HEXAHEDRON.lattice.T
    first, second = (2 * np.arange(size // 2)[:, None] for size in number.shape[:2])
    return np.asarray(number[(first + i)[:, None], (second + j)[None], k])


def mean_of_cells(values: Array) -> Array:
    """Means over cells of what is known at the nodes of one face of a grid.

    Args:
        values: Shape (2 m + 1, 2 n + 1).

    Returns:
        Shape (m, n), by Simpson's rule.
    """
    along = sum(w * values[k : len(values) - 2 + k : 2] for k, w in enumerate(_SIMPSON))
    n = values.shape[1]
    return np.asarray(sum(w * along[:, k : n - 2 + k : 2] for k, w in enumerate(_SIMPSON)))
