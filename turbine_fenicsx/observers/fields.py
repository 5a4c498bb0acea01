"""Field output: all flexible bodies and the surfaces of rigid ones in one moving grid."""

from __future__ import annotations

import os
from collections.abc import Sequence

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.observers.xdmf import XdmfSeries
from turbine_fenicsx.rigid_surface import RigidSurface
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.simulation import Snapshot
from turbine_fenicsx.state import State
from turbine_fenicsx.system import MultibodySystem

VTK_ORDER = {"hexahedron": [0, 1, 3, 2, 4, 5, 7, 6], "tetrahedron": [0, 1, 2, 3]}
"""Vertices of DOLFINx cells in the order of VTK."""


class Fields:
    """Writes ``fields.xdmf``: displacement, velocity, Cauchy stress norm and fibre direction.

    Points are the vertices at their current positions; stresses are those of the cell centres.

    Args:
        system: The system.
        path: The XDMF file.
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].
        surfaces: Surfaces of rigid bodies, written by rank 0.
        parts: Number of the part of each local cell (ghosts included), one array per flexible
            body.
        keep_until: Keep the times of an existing file before this one [s], where the run goes on;
            None begins a new file.
    """

    def __init__(
        self,
        system: MultibodySystem,
        path: str | os.PathLike[str],
        every: float,
        end: float,
        surfaces: Sequence[RigidSurface] = (),
        parts: Sequence[Array] = (),
        keep_until: float | None = None,
    ) -> None:
        """Lay out the grid and create the files."""
        self._system, self._every, self._end = system, every, end
        comm = system.comm
        self._surfaces = tuple(surfaces) if comm.rank == 0 else ()
        self._bodies = [_BodyOutput(block) for block in system.flexible_blocks]
        counts = [b.n_points for b in self._bodies] + [sum(len(s.points) for s in self._surfaces)]
        all_counts = np.array(comm.allgather(counts))
        starts = np.cumsum(all_counts.ravel()).reshape(all_counts.shape) - all_counts
        cells = []
        for k, body in enumerate(self._bodies):
            cells.append((body.kind, body.cells(comm, starts[:, k])))
        first = int(starts[comm.rank, -1])
        quadrilaterals, part = [np.zeros((0, 4), np.int64)], [np.zeros(0)]
        for surface in self._surfaces:
            quadrilaterals.append(first + surface.quadrilaterals)
            part.append(np.full(len(surface.quadrilaterals), float(surface.part)))
            first += len(surface.points)
        cells.append(("quadrilateral", np.concatenate(quadrilaterals)))
        self._n_faces = len(cells[-1][1])
        body_parts = [p[: b.n_cells] for p, b in zip(parts, self._bodies, strict=True)]
        self._series = XdmfSeries(
            comm,
            path,
            cells,
            sum(counts),
            cell_data={"part": np.concatenate([*body_parts, *part]).astype(np.int32)},
            append=keep_until,
        )
        last = self._series.last_kept
        self._next = np.ceil((keep_until or 0.0) / every - 1e-9) * every
        if last is not None:
            self._next = (np.floor(last / every + 1e-9) + 1.0) * every

    def observe(self, snapshot: Snapshot) -> None:
        """Write if it is time to."""
        t = snapshot.state.time
        slack = 1e-9 * self._every
        if t < min(self._next, self._end) - slack:
            return
        self._next = (np.floor(t / self._every + 1e-9) + 1.0) * self._every
        self.write(snapshot.state)

    def finish(self) -> None:
        """Nothing is left open."""

    def write(self, state: State) -> None:
        """Write one state. Collective."""
        points, u, v = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros((0, 3))]
        stress, fibre = [], []
        for k, body in enumerate(self._bodies):
            u_k, v_k = body.vertex_values(state.u[k]), body.vertex_values(state.v[k])
            points.append(body.positions + u_k)
            u.append(u_k)
            v.append(v_k)
            stress.append(body.stress_norm(state.u[k]))
            fibre.append(body.fibre(state.u[k]))
        coordinates = self._system.coordinates_of(state.q)
        rates = self._system.coordinates_of(state.q_dot)
        for surface in self._surfaces:
            xi = surface.body.body_coordinates(surface.points)
            weights = np.column_stack([np.ones(len(xi)), xi])
            x = weights @ coordinates[surface.body].reshape(4, 3)
            points.append(x)
            u.append(x - surface.points)
            v.append(weights @ rates[surface.body].reshape(4, 3))
        stress.append(np.zeros(self._n_faces))
        fibre.append(np.zeros((self._n_faces, 3)))
        self._series.write(
            state.time,
            np.concatenate(points),
            point_data={"displacement": np.concatenate(u), "velocity": np.concatenate(v)},
            cell_data={
                "cauchy_stress_norm": np.concatenate(stress),
                "fibre": np.concatenate(fibre),
            },
        )


class _BodyOutput:
    """Vertices and cells of one flexible body.

    Vertices are the nodes of a linear space, which for linear fields is that of the field itself.
    """

    def __init__(self, block: FlexibleBlock) -> None:
        """Match the vertices of the mesh with the nodes of the field."""
        self._block = block
        mesh = block.body.mesh
        self.kind = _compat.cell_name(mesh)
        vertex_space = block.space if block.body.degree == 1 else _compat.vector_space(mesh, 1)
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
        X = fem.Function(block.space)
        X.interpolate(lambda x: x)
        self.positions = X.x.array.reshape(-1, 3)[self._node_of]

    def cells(self, comm: MPI.Intracomm, starts: Array) -> Array:
        """Vertices of the owned cells by their numbers in the output, shape (n_cells, .).

        Args:
            comm: Communicator.
            starts: Number of the first vertex of this body on each rank, shape (ranks,).
        """
        vertices = self._index_map.local_to_global(
            np.arange(self.n_points + self._index_map.num_ghosts, dtype=np.int32)
        )
        firsts = np.array(comm.allgather(self._index_map.local_range[0]))
        sizes = np.array(comm.allgather(self.n_points))
        owner = np.searchsorted(firsts + sizes, vertices, side="right")
        return (starts[owner] + vertices - firsts[owner])[self._vertices]

    def vertex_values(self, vector: PETSc.Vec) -> Array:
        """Values of a nodal vector at the owned vertices, shape (n_points, 3)."""
        return self._block.nodal_values(vector)[self._node_of]

    def stress_norm(self, u: PETSc.Vec) -> Array:
        """Norm of the Cauchy stress at the centres of the owned cells, shape (n_cells,) [Pa]."""
        return self._block.cauchy_stress_norm(u)[: self.n_cells]

    def fibre(self, u: PETSc.Vec) -> Array:
        """Present direction of the fibre in the owned cells, shape (n_cells, 3); zero without."""
        directions = self._block.fibre_directions(u)
        return np.zeros((self.n_cells, 3)) if directions is None else directions[: self.n_cells]
