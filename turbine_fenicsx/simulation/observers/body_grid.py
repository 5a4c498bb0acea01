"""Vertices and cells of a flexible body as they go to a file of fields."""

from __future__ import annotations

from functools import cached_property

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.owned_nodes import nodes_of_facets
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.cell_centres import CellCentres
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.system import MultibodySystem

VTK_ORDER = {"hexahedron": [0, 1, 3, 2, 4, 5, 7, 6], "tetrahedron": [0, 1, 2, 3]}
"""Vertices of DOLFINx cells in the order of VTK."""


class BodyGrid:
    """Vertices and cells of a copy of a flexible body.

    Vertices are the nodes of a linear space, which for linear fields is that of the field itself.

    Args:
        number: Number of the body in the system.
        copy: Number of the copy.

    Attributes:
        n_points: Number of vertices that this rank owns.
        n_cells: Number of cells that this rank owns.
        positions: Initial positions of the vertices, shape (n_points, 3) [m].
    """

    def __init__(self, system: MultibodySystem, number: int, copy: int) -> None:
        self._system, self.number, self._copy = system, number, copy
        self._block = block = system.flexible_models[number]
        self.body, mesh = block.body, block.space.mesh
        self.kind = _compat.cell_name(mesh)
        linear = block.body.full.degree == 1
        vertex_space = block.space if linear else _compat.vector_space(mesh, 1)
        self._index_map = vertex_space.dofmap.index_map
        self.n_points = self._index_map.size_local
        n_vertices = 8 if self.kind == "hexahedron" else 4
        vertices = _compat.dofs_of_cells(vertex_space)[:, :n_vertices]
        nodes = _compat.dofs_of_cells(block.space)[:, :n_vertices]
        self._node_of = np.zeros(self.n_points + self._index_map.num_ghosts, dtype=np.int64)
        self._node_of[vertices] = nodes
        self._node_of = self._node_of[: self.n_points]
        self.n_cells = mesh.topology.index_map(3).size_local
        self._vertices = vertices[: self.n_cells, VTK_ORDER[self.kind]]
        self._values = fem.Function(block.space)
        self._values.interpolate(lambda x: x)
        self._rotation, at = block.body.placements[copy].frame()
        X = self._values.x.array.reshape(-1, 3)[self._node_of]
        self.positions: Array = at + X @ self._rotation.T

    def cells(self, comm: MPI.Intracomm, starts: IntArray) -> IntArray:
        """Vertices of the owned cells by their numbers in the output, shape (n_cells, .).

        Args:
            starts: Number of the first vertex of this body on each rank, shape (ranks,).
        """
        vertices = self._index_map.local_to_global(
            np.arange(self.n_points + self._index_map.num_ghosts, dtype=np.int32)
        )
        firsts = np.array(comm.allgather(self._index_map.local_range[0]))
        sizes = np.array(comm.allgather(self.n_points))
        owner = np.searchsorted(firsts + sizes, vertices, side="right")
        numbers: IntArray = (starts[owner] + vertices - firsts[owner])[self._vertices]
        return numbers

    def motion(self, u: PETSc.Vec) -> Array:
        """Motion of the owned vertices by that of the body, shape (n_points, 3). Collective."""
        own = self._block.mesh_displacements(u, self._copy)
        self._values.x.array[: own.size] = own.ravel()
        self._values.x.scatter_forward()
        found: Array = self._values.x.array.reshape(-1, 3)[self._node_of] @ self._rotation.T
        return found

    def couplings(self) -> npt.NDArray[np.int32]:
        """Number of the coupling that holds each owned vertex, from 1; 0 for none. Collective."""
        found = np.zeros(self.n_points, dtype=np.int32)
        numbers, space = self._values.x.array, self._block.space
        for number, coupling in enumerate(self._system.couplings, start=1):
            if coupling.flexible is self.body and coupling.copy == self._copy:
                numbers[:] = 0.0
                facets = check_facets(coupling.name, space.mesh, coupling.facets)
                numbers[3 * nodes_of_facets(space, facets)] = 1.0
                self._values.x.scatter_forward()
                found[numbers[3 * self._node_of] > 0.5] = number
        return found

    @cached_property
    def _centres(self) -> CellCentres:
        """Stresses at the centres of the cells of a body of a material."""
        return CellCentres(on_mesh(self._block, "stresses"))

    def stresses(self, u: PETSc.Vec) -> tuple[Array, Array]:
        """Norm and von Mises stress at the centres of the owned cells, shapes (n_cells,) [Pa]."""
        norm, von_mises = (values[: self.n_cells] for values in self._centres.stresses(u))
        return norm, von_mises

    def fibre(self, u: PETSc.Vec) -> Array:
        """Present direction of the fibre in the owned cells, shape (n_cells, 3); zero without."""
        directions = self._centres.fibres(u)
        return np.zeros((self.n_cells, 3)) if directions is None else directions[: self.n_cells]
