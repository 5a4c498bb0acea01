"""Field output: all flexible bodies and the surfaces of rigid ones in one moving grid."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.rigid_surface import RigidSurface, inertia_box
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.postprocessing.parts import Part, Parts
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.observers.carriers import find_carriers
from turbine_fenicsx.simulation.observers.stored_grids import read_grids
from turbine_fenicsx.simulation.observers.xdmf import XdmfSeries
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.restart_data import RestartData
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

VTK_ORDER = {"hexahedron": [0, 1, 3, 2, 4, 5, 7, 6], "tetrahedron": [0, 1, 2, 3]}
"""Vertices of DOLFINx cells in the order of VTK."""


class Fields:
    """Writes ``fields.xdmf``: displacement, velocity, Cauchy stress and fibre direction.

    Points are the vertices at their current positions; stresses are those of the cell centres.

    Args:
        system: The system.
        path: The XDMF file.
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].
        surfaces: Surfaces of rigid bodies, written by rank 0; if None, each is drawn as the
            homogeneous box of its mass and Euler values.
        parts: Number of the part of each local cell (ghosts included), one array per flexible
            body; if None, each body is one part, with the next free numbers.
        names: Names of the numbered parts that are not called like their bodies.

    Attributes:
        name: Name of the XDMF file, under which checkpoints know it.

    Raises:
        ModelError: if there is not one array of parts for each flexible body.
    """

    def __init__(
        self,
        system: MultibodySystem,
        path: str | os.PathLike[str],
        every: float,
        end: float,
        surfaces: Sequence[RigidSurface] | None = None,
        parts: Sequence[Array] | None = None,
        names: Mapping[int, str] | None = None,
    ) -> None:
        self._system, self._every, self._end = system, every, end
        self._path, self.name = Path(path), Path(path).name
        comm = system.comm
        if surfaces is None:
            surfaces = [inertia_box(body, k) for k, body in enumerate(system.rigid_bodies)]
        self._bodies = [_BodyOutput(block) for block in system.flexible_models]
        if parts is None:
            free = 1 + max((surface.part for surface in surfaces), default=-1)
            parts = [np.full(b.n_cells, free + k) for k, b in enumerate(self._bodies)]
        if len(parts) != len(self._bodies):
            raise ModelError(
                f"{len(parts)} arrays of parts for {len(self._bodies)} flexible bodies"
            )
        cell_parts = [p[: b.n_cells] for p, b in zip(parts, self._bodies, strict=True)]
        about = _describe(system, surfaces, cell_parts, names or {})
        self._surfaces = tuple(surfaces) if comm.rank == 0 else ()
        counts = [b.n_points for b in self._bodies] + [sum(len(s.points) for s in self._surfaces)]
        all_counts = np.array(comm.allgather(counts))
        starts = np.cumsum(all_counts.ravel()).reshape(all_counts.shape) - all_counts
        cells = []
        for k, body in enumerate(self._bodies):
            cells.append((body.kind, body.cells(comm, starts[:, k])))
        first = int(starts[comm.rank, -1])
        quadrilaterals = [np.zeros((0, 4), np.int64)]
        for surface in self._surfaces:
            quadrilaterals.append(first + surface.quadrilaterals)
            cell_parts.append(np.full(len(surface.quadrilaterals), surface.part))
            first += len(surface.points)
        cells.append(("quadrilateral", np.concatenate(quadrilaterals)))
        self._n_faces = len(cells[-1][1])
        held = [body.couplings(system) for body in self._bodies]
        self._open = partial(
            XdmfSeries,
            comm,
            path,
            cells,
            sum(counts),
            point_data={"coupling": np.concatenate([*held, np.zeros(counts[-1], np.int32)])},
            cell_data={"part": np.concatenate([np.zeros(0), *cell_parts]).astype(np.int32)},
            information={"parts": about.to_text()},
        )
        self._series: XdmfSeries | None = None
        self._last: float | None = None
        self._next = 0.0

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Open the files, which keep their times before the first state if the run goes on.

        Raises:
            FileError: if they cannot be written, on all ranks.
        """
        time, every = snapshot.state.time, self._every
        self._series = self._open(append=time if resumed else None)
        self._last = last = self._series.last_kept
        self._next = np.ceil(time / every - 1e-9) * every
        if last is not None:
            self._next = (np.floor(last / every + 1e-9) + 1.0) * every
        self.observe(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Write if it is time to."""
        t = snapshot.state.time
        slack = 1e-9 * self._every
        if t < min(self._next, self._end) - slack:
            return
        self._next = (np.floor(t / self._every + 1e-9) + 1.0) * self._every
        self._write(snapshot.state)

    def save(self) -> RestartData:
        """Bring the times to the disk; their number and the last one. Collective."""
        assert self._series is not None
        return RestartData({"times": self._series.sync(), "last_time": self._last})

    def restore(self, data: RestartData) -> None:
        """The files themselves have all that is needed."""

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Times that the files lack before a checkpoint; that of the checkpoint is written anew."""
        first, n = time - 1e-9 * max(1.0, abs(time)), data.numbers
        there = sum(grid.time < first for grid in read_grids(self._path))
        needed = n["times"] - (n["times"] > 0 and n["last_time"] >= first)
        return describe_shortfall(self.name, there, needed, "times", time)

    def finish(self) -> None:
        """Nothing is left open."""

    def _write(self, state: State) -> None:
        assert self._series is not None
        self._last = state.time
        points, u, v = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros((0, 3))]
        norm, von_mises, fibre = [], [], []
        for k, body in enumerate(self._bodies):
            u_k, v_k = body.vertex_values(state.u[k]), body.vertex_values(state.v[k])
            points.append(body.positions + u_k)
            u.append(u_k)
            v.append(v_k)
            stress = body.stresses(state.u[k])
            norm.append(stress[0])
            von_mises.append(stress[1])
            fibre.append(body.fibre(state.u[k]))
        coordinates = self._system.coordinates_of(state.q)
        rates = self._system.coordinates_of(state.q_dot)
        for surface in self._surfaces:
            rigid = surface.body
            xi = rigid.body_coordinates(surface.points)
            weights = np.column_stack([np.ones(len(xi)), xi])
            moved = coordinates[rigid] - rigid.coordinates  # exactly zero at the start
            u.append(weights @ moved.reshape(4, 3))
            points.append(surface.points + u[-1])
            v.append(weights @ rates[rigid].reshape(4, 3))
        for values in (norm, von_mises):
            values.append(np.zeros(self._n_faces))
        fibre.append(np.zeros((self._n_faces, 3)))
        self._series.write(
            state.time,
            np.concatenate(points),
            point_data={"displacement": np.concatenate(u), "velocity": np.concatenate(v)},
            cell_data={
                "cauchy_stress_norm": np.concatenate(norm),
                "von_mises_stress": np.concatenate(von_mises),
                "fibre": np.concatenate(fibre),
            },
        )


def _describe(
    system: MultibodySystem,
    surfaces: Sequence[RigidSurface],
    cell_parts: Sequence[Array],
    names: Mapping[int, str],
) -> Parts:
    """Names of all parts and what carries them. Collective."""
    stands_on, roots = find_carriers(system)
    found = {}
    for surface in surfaces:
        name, number = surface.body.name, surface.part
        found[number] = Part(number, names.get(number, name), name, stands_on[surface.body])
    for body, mine in zip(system.flexible_bodies, cell_parts, strict=True):
        for number in sorted(set().union(*system.comm.allgather(set(mine.astype(int).tolist())))):
            found[number] = Part(number, names.get(number, body.name), body.name)
    return Parts(tuple(found.values()), roots)


class _BodyOutput:
    """Vertices and cells of one flexible body.

    Vertices are the nodes of a linear space, which for linear fields is that of the field itself.
    """

    def __init__(self, block: FlexibleModel) -> None:
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

    def cells(self, comm: MPI.Intracomm, starts: IntArray) -> IntArray:
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
        numbers: IntArray = (starts[owner] + vertices - firsts[owner])[self._vertices]
        return numbers

    def vertex_values(self, vector: PETSc.Vec) -> Array:
        """Values of a nodal vector at the owned vertices, shape (n_points, 3)."""
        return self._block.nodal_values(vector)[self._node_of]

    def couplings(self, system: MultibodySystem) -> npt.NDArray[np.int32]:
        """Number of the coupling that holds each owned vertex, from 1; 0 for none. Collective."""
        k = system.flexible_models.index(self._block)
        held = system.coupling_blocks[k]
        numbers = self._block.new_vector()
        for coupling, rows in zip(held.couplings, held.slices, strict=True):
            dofs = 3 * held.nodes[rows]
            numbers.array[dofs] = 1 + system.couplings.index(coupling)
        values = self._block.nodal_values(numbers)[self._node_of, 0]
        numbers.destroy()
        found: npt.NDArray[np.int32] = np.rint(values).astype(np.int32)
        return found

    def stresses(self, u: PETSc.Vec) -> tuple[Array, Array]:
        """Norm and von Mises stress at the centres of the owned cells, shapes (n_cells,) [Pa]."""
        norm, von_mises = (values[: self.n_cells] for values in self._block.cauchy_stresses(u))
        return norm, von_mises

    def fibre(self, u: PETSc.Vec) -> Array:
        """Present direction of the fibre in the owned cells, shape (n_cells, 3); zero without."""
        directions = self._block.fibre_directions(u)
        return np.zeros((self.n_cells, 3)) if directions is None else directions[: self.n_cells]
