"""Strains, stresses and failure indices of the plies in the walls of a flexible body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.laminate_theory import Plies
from turbine_fenicsx.materials.ply_table import Criterion, PlyTable
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.system.wall_strains import WallStrains


class PlyStresses:
    """Where the plies of a body are strained, and how near they are to failing.

    Strains are those of Green and Lagrange at both faces of the wall. Each face has four points,
    two along the span and two around the section, where quadratic cells are most accurate. Plies
    have the linear interpolation between the faces. Stresses are those of plane stress in the
    plies, also where the cell is homogenised.

    Args:
        system: The system.
        body: A flexible or reduced body of the system, the cells of its mesh as
            `turbine_fenicsx.materials.laminate` needs them.
        laminates: The plies of each cell that this rank owns, from the outer to the inner face.

    Attributes:
        body: The body on its mesh.
        copies: Number of copies of the body.
        table: The plies of these cells.
        inner: Strains 11, 22, 12 in the axes of the wall at the inner faces, shape (cells, 4, 3).
        outer: Those at the outer faces.
        walls: Rows of the strains over the nodes of the mesh.

    Raises:
        ModelError: for a body that is not part of the system, or another number of laminates than
            cells, on all ranks.

    Note:
        Making it and `update` are collective.
    """

    def __init__(
        self, system: MultibodySystem, body: DeformableBody, laminates: Sequence[Plies]
    ) -> None:
        check_among_parts("flexible body", body, system.flexible_bodies)
        self._index = system.flexible_bodies.index(body)
        self._model = system.flexible_models[self._index]
        self.copies, self.body = len(body.placements), body.full
        mesh = self.body.mesh
        n = mesh.topology.index_map(3).size_local
        error = None
        if len(laminates) != n:
            error = ModelError(
                f"plies of {body.name!r} are needed for each of the {n} cells of this rank, got "
                f"{len(laminates)} laminates"
            )
        elif not all(laminates):
            error = ModelError(f"a cell of {body.name!r} has no plies")
        raise_together(mesh.comm, error)
        self.table = PlyTable(laminates)
        self._u, self.walls = fem.Function(self._model.space), WallStrains.of(self._model.space)
        self.inner, self.outer = np.zeros((2, n, 4, 3))

    def update(self, state: State, copy: int = 0) -> None:
        """Take the strains of a state. Collective.

        Args:
            state: A state of the system.
            copy: Number of the copy of a reduced body.
        """
        u = self._model.mesh_displacements(state.u[self._index], copy)
        self._u.x.array[: u.size] = u.ravel()
        self._u.x.scatter_forward()
        found = self.walls.strains(self._u.x.array.reshape(-1, 1, 3))[:, :, :, 0]
        self.inner, self.outer = np.moveaxis(found, 1, 0)

    def strains(self) -> Array:
        """Along the fibre, across it, and shear, at both faces of each ply and at four points.

        Returns:
            Shape (plies, 2, 4, 3), outer faces first.
        """
        return self.table.strains(self.inner, self.outer)

    def stresses(self) -> Array:
        """Those of `strains` [Pa]."""
        return self.table.stresses(self.strains())

    def largest(self, criterion: Criterion) -> tuple[Array, IntArray]:
        """The largest failure index of each cell, and the ply where it is.

        Args:
            criterion: One of `turbine_fenicsx.materials.ply_failure`.

        Returns:
            Shapes (cells,), cells that this rank owns; plies count from the outer face, from 0.
        """
        return self.table.largest(criterion(self.table, self.strains()))
