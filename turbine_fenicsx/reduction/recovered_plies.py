"""Strains and failure of the plies of a reduced body, for many states together."""

from __future__ import annotations

from copy import copy as shallow_copy

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_table import Criterion
from turbine_fenicsx.system.ply_stresses import PlyStresses
from turbine_fenicsx.system.reduced_model import ReducedModel


class RecoveredPlies:
    """Strains and failure indices of plies, from the vectors of a reduced body.

    Args:
        model: The body.
        plies: Its plies.

    Attributes:
        table: The plies of the cells that this rank owns.

    Raises:
        ModelError: for plies of another body.

    Note:
        Making it is collective.
    """

    def __init__(self, model: ReducedModel, plies: PlyStresses) -> None:
        if plies.body is not model.body.full:
            raise ModelError(f"the plies are not those of {model.body.name!r}")
        index_map = model.space.dofmap.index_map
        local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        functions = model.functions_at(index_map.local_to_global(local))
        self._walls = plies.walls.over(functions)
        self._body, self.table = model.body, plies.table

    def take(self, cells: IntArray) -> RecoveredPlies:
        """The plies of some cells, numbers local to this rank."""
        found = shallow_copy(self)
        found._walls, found.table = self._walls.take(cells), self.table.take(cells)
        return found

    def move(self, vectors: Array, copy: int = 0) -> Array:
        """Displacements of the vectors in the axes of the mesh, for m states.

        Args:
            vectors: Vectors z of a copy in m states, shape (m, n, 3) [m].
            copy: Number of the copy.

        Returns:
            Shape (n, m, 3) [m].
        """
        basis, (R, t) = self._body.basis, self._body.placements[copy].frame()
        moved = (vectors - np.outer(basis.is_point, t)) @ R - basis.vectors
        return np.ascontiguousarray(moved.swapaxes(0, 1))

    def strains(self, vectors: Array, copy: int = 0) -> Array:
        """Strains 11, 22, 12 (engineering) of both faces of the walls, in their axes.

        Args:
            vectors: As of `move`.
            copy: Number of the copy.

        Returns:
            Shape (cells, 2, 4, m, 3): inner and outer face, points of a face.
        """
        return self._walls.strains(self.move(vectors, copy))

    def find_mean_strains(self, moved: Array) -> Array:
        """Those of `strains` as means over the points of each face.

        Args:
            moved: Of `move`.

        Returns:
            Shape (cells, 6, m): 11, 22, 12 of the inner face, then of the outer one.
        """
        means = self._walls.strains(moved).mean(axis=2)
        return np.ascontiguousarray(means.swapaxes(2, 3)).reshape(len(means), 6, -1)

    def find_mean_stresses(self, moved: Array) -> Array:
        """Stresses along and across the fibre, and of shear, at both faces of plies.

        They are means over the points of each cell.

        Args:
            moved: Of `move`.

        Returns:
            Shape (plies, 2, 3, m), outer faces first [Pa].
        """
        rows = self.table.stress_rows.reshape(-1, 6, 6)
        stresses = rows @ self.find_mean_strains(moved)[self.table.wall]
        return stresses.reshape(len(rows), 2, 3, -1)

    def find_largest(
        self, criterion: Criterion, vectors: Array, copy: int = 0
    ) -> tuple[Array, IntArray]:
        """The largest failure index of each cell in each state, and the ply where it is.

        Args:
            criterion: One of `turbine_fenicsx.materials.ply_failure`.
            vectors: As of `strains`.
            copy: Number of the copy.

        Returns:
            Shapes (cells, m); plies of a cell count from its outer face, from 0.
        """
        E = self.strains(vectors, copy)
        inner, outer = E.reshape(len(E), 2, -1, 3).swapaxes(0, 1)
        indices = criterion(self.table, self.table.strains(inner, outer))
        of_faces = indices.reshape(len(indices), 2 * E.shape[2], len(vectors))
        return self.table.find_largest(of_faces.max(axis=1))
