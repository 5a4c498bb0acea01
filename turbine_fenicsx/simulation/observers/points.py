"""Position and velocity of material points of rigid and flexible bodies.

A point X of a flexible body is at X + sum_a N_a(X) u_a, with the shape functions N_a of the cell
that holds it. They are evaluated once; in a run each rank adds up what its own nodes contribute.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, vstack

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts, check_vectors, describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.body_model import BodyModel
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
    body: RigidBody | DeformableBody
    position: npt.ArrayLike

    def __post_init__(self) -> None:
        check_vectors(self.name, position=self.position)
        if not isinstance(self.body, RigidBody | DeformableBody):
            raise TypeError(
                f"{self.name!r} needs a rigid or flexible body, got {describe(self.body)}"
            )


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
            self._flexible.append((mine, _find_rows(model, X[mine], names)))

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
            if rows:
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


def _find_rows(model: BodyModel, X: Array, names: Sequence[str]) -> csr_matrix:
    """Weights of the owned nodes of a body at points. Collective.

    Args:
        X: The points in the initial configuration, shape (n, 3) [m].

    Returns:
        Shape (n, n_owned).
    """
    rows = []
    for point, name in zip(X, names, strict=True):
        weights = model.weights_at(point)
        if weights is None:
            nearest = model.distance_from(point)
            raise ModelError(
                f"point {name!r} at {point.tolist()} is outside flexible body "
                f"{model.body.name!r}, whose nearest node is {nearest:.3g} m away"
            )
        rows.append(csr_matrix(weights))
    return vstack(rows, "csr") if rows else csr_matrix((0, model.n_owned))
