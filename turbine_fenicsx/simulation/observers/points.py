"""Position and velocity of material points of rigid and flexible bodies.

A point X of a flexible body is at X + sum_a N_a(X) u_a, with the shape functions N_a of the cell
that holds it. They are evaluated once; in a run each rank adds up what its own nodes contribute.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from dolfinx import fem
from scipy.sparse import csr_matrix

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.checks import check_among_parts, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Point:
    """A material point to follow.

    Args:
        name: Name of its columns.
        body: Rigid or flexible body that it belongs to.
        position: Its position in the initial configuration [m], shape (3,).

    Raises:
        ModelError: if the position is not three numbers.
        TypeError: if the body is not one.
    """

    name: str
    body: RigidBody | FlexibleBody
    position: npt.ArrayLike

    def __post_init__(self) -> None:
        check_vectors(self.name, position=self.position)
        if not isinstance(self.body, RigidBody | FlexibleBody):
            raise TypeError(f"{self.name!r} needs a rigid or flexible body, got {self.body!r}")


class Points:
    """Positions and velocities of material points.

    Args:
        system: The system.
        points: The points.

    Attributes:
        points: The points.

    Raises:
        ModelError: for a body that is not part of the system, or a point outside its flexible body.

    Note:
        Collective.
    """

    def __init__(self, system: MultibodySystem, points: Sequence[Point]) -> None:
        self.points = tuple(points)
        self._comm = system.comm
        bodies = [*system.rigid_bodies, *system.flexible_bodies]
        for point in self.points:
            check_among_parts("body", point.body, bodies, f"point {point.name!r}")
        X = np.array([point.position for point in self.points], dtype=float).reshape(-1, 3)
        rows = [k for k, p in enumerate(self.points) if isinstance(p.body, RigidBody)]
        self._rigid = np.array(rows, dtype=np.int64)
        on_rigid = [p.body for p in self.points if isinstance(p.body, RigidBody)]
        self._slots = np.array([system.rigid_bodies.index(b) for b in on_rigid], dtype=np.int64)
        xi = [b.body_coordinates(X[k]) for k, b in zip(rows, on_rigid, strict=True)]
        self._weights = np.column_stack([np.ones(len(xi)), np.array(xi).reshape(-1, 3)])
        self._start = X.copy()
        self._start[self._rigid] = 0.0
        self._flexible = []
        for model in system.flexible_models:
            mine = [k for k, p in enumerate(self.points) if p.body is model.body]
            names = [self.points[k].name for k in mine]
            N = _shape_functions(on_mesh(model, "points"), X[mine], names) if mine else None
            self._flexible.append((mine, N))

    def at(self, snapshot: Snapshot) -> Array:
        """Positions [m] and velocities [m/s] at a snapshot, shape (n, 2, 3), equal on all ranks.

        Note:
            Collective.
        """
        return self.motion(snapshot.state)

    def motion(self, state: State) -> Array:
        """Positions [m] and velocities [m/s] of a state, shape (n, 2, 3), equal on all ranks.

        Note:
            Collective.
        """
        return sum_over_ranks(self._comm, self._local(state))

    def _local(self, state: State) -> Array:
        """Contribution of this rank, shape (n, 2, 3); rank 0 adds what all ranks know."""
        found = np.zeros((len(self.points), 2, 3))
        for k, (rows, N) in enumerate(self._flexible):
            if N is not None:
                found[rows, 0] = N @ state.u[k].array_r.reshape(-1, 3)
                found[rows, 1] = N @ state.v[k].array_r.reshape(-1, 3)
        if self._comm.rank == 0:
            found[:, 0] += self._start
            for k, q in enumerate((state.q, state.q_dot)):
                slots = q.reshape(-1, 4, 3)[self._slots]
                found[self._rigid, k] = np.einsum("ns,nsi->ni", self._weights, slots)
        return found


def point_channel(points: Points) -> Channel:
    """Position and velocity of each point, three columns each."""
    columns = tuple(
        family(point=point.name, axis=i)
        for point in points.points
        for family in (names.POSITION, names.VELOCITY)
        for i in (1, 2, 3)
    )
    return Channel(columns, lambda s: points.at(s).ravel().tolist())


def _shape_functions(block: FlexibleModel, X: Array, names: Sequence[str]) -> csr_matrix:
    """Values of the shape functions of this rank's nodes at points. Collective.

    Args:
        block: The flexible block.
        X: The points in the initial configuration, shape (n, 3) [m].
        names: Their names, for messages.

    Returns:
        Shape (n, n_owned).

    Raises:
        ModelError: if a point is outside the body, on all ranks.
    """
    comm, index_map = block.body.mesh.comm, block.space.dofmap.index_map
    first, end = index_map.local_range
    function = fem.Function(block.space)  # collective
    rows, columns, values = [], [], []
    for k, point in enumerate(X):
        cells = _compat.cells_at(block.body.mesh, point)
        found = None if cells.size == 0 else _in_cell(function, int(cells[0]), point)
        holders = [x for x in comm.allgather(found) if x is not None]
        if not holders:
            d = np.linalg.norm(block.positions - point, axis=1)
            nearest = comm.allreduce(float(np.min(d, initial=np.inf)), op=min)
            raise ModelError(
                f"point {names[k]!r} at {point.tolist()} is outside flexible body "
                f"{block.body.name!r}, whose nearest node is {nearest:.3g} m away"
            )
        nodes, weights = holders[0]  # neighbours that share the point agree on its motion
        mine = (nodes >= first) & (nodes < end)
        rows += [k] * int(np.sum(mine))
        columns += (nodes[mine] - first).tolist()
        values += weights[mine].tolist()
    return csr_matrix((values, (rows, columns)), shape=(len(X), block.n_owned))


def _in_cell(function: Any, cell: int, point: Array) -> tuple[npt.NDArray[np.int64], Array]:
    """Nodes of a cell, counted over all ranks, and their shape functions at a point.

    Args:
        function: A function of the space, overwritten.
        cell: The cell.
        point: Shape (3,).
    """
    space = function.function_space
    nodes = _compat.dofs_of_cells(space)[cell]
    weights = np.zeros(len(nodes))
    for k, node in enumerate(nodes):
        function.x.array[:] = 0.0
        function.x.array[3 * node] = 1.0
        weights[k] = np.ravel(function.eval(point, np.array([cell], dtype=np.int32)))[0]
    return space.dofmap.index_map.local_to_global(nodes.astype(np.int32)), weights
