"""Deflection of points of flexible bodies relative to a rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import GROUND, RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts, check_array, check_vectors
from turbine_fenicsx.foundation.parallel import largest_of_ranks, sum_over_ranks
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.mesh_view import MeshView
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Tip:
    """A point to follow.

    Args:
        name: Column ``tip_deflection_NAME_[m]``.
        body: Flexible body; the node of its mesh nearest to the point is followed.
        point: Initial position [m], shape (3,).
        carrier: Rigid body whose frame the deflection is measured in; None is the ground.
        axes: Axes of the components, fixed to the parent body; their initial directions as rows,
            shape (3, 3). The directors of the parent body if None, e1, e2, e3 on the ground.
    """

    name: str
    body: DeformableBody
    point: npt.ArrayLike
    carrier: RigidBody | None
    axes: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point)
        if self.axes is not None:
            check_array(f"axes of {self.name!r}", self.axes, (3, 3), "three rows of three numbers")


class _Followed(NamedTuple):
    """A tip of this rank: numbers of tip and body, nodes that move it, coordinates of its carrier.

    X is its initial position, xi that in the frame of the carrier.
    """

    number: int
    body: int
    nodes: IntArray
    weights: Array
    coordinates: slice | None
    X: Array
    xi: Array
    axes: Array


class Tips:
    """Deflections R^T (x - phi) - xi of points in the frames of their parent bodies.

    Args:
        system: The system.
        tips: The points.

    Attributes:
        starts: Initial positions of the nodes that are followed, shape (n, 3) [m].

    Raises:
        ModelError: for a body or parent body that is not part of the system.

    Note:
        Collective.
    """

    def __init__(self, system: MultibodySystem, tips: Sequence[Tip]) -> None:
        self._comm = system.comm
        self.tips = tuple(tips)
        self._mine: list[_Followed] = []
        for k, tip in enumerate(self.tips):
            whose = f"tip {tip.name!r}"
            check_among_parts("body", tip.body, system.flexible_bodies, whose)
            if tip.carrier is not None:
                check_among_parts("body", tip.carrier, system.rigid_bodies, whose)
            index = system.flexible_bodies.index(tip.body)
            model = system.flexible_models[index]
            found = MeshView(model).find_node(tip.point)
            if found is not None:
                nodes, weights = found
                X, axes, R = weights @ model.positions[nodes], np.eye(3), np.eye(3)
                xi, q = X, None
                if tip.carrier is not None:
                    first = system.first_coordinate[tip.carrier]
                    xi, q = tip.carrier.body_coordinates(X), slice(first, first + 12)
                    R = np.asarray(tip.carrier.directors, dtype=float)
                if tip.axes is not None:
                    axes = np.asarray(tip.axes, dtype=float) @ R
                self._mine.append(_Followed(k, index, nodes, weights, q, X, xi, axes))
        starts = np.zeros((len(self.tips), 3))
        for mine in self._mine:
            starts[mine.number] = mine.X
        self.starts: Array = sum_over_ranks(self._comm, starts)

    def at(self, snapshot: Snapshot) -> Array:
        """Deflections at a snapshot [m], shape (n, 3), equal on all ranks. Collective."""
        return sum_over_ranks(self._comm, self._local(snapshot))

    def _local(self, snapshot: Snapshot) -> Array:
        """Deflections of the nodes of this rank, zero for the others."""
        deflections = np.zeros((len(self.tips), 3))
        state = snapshot.state
        for tip in self._mine:
            q = GROUND if tip.coordinates is None else state.q[tip.coordinates]
            phi, directors = q[:3], q[3:].reshape(3, 3)
            x = tip.X + tip.weights @ state.u[tip.body].array_r.reshape(-1, 3)[tip.nodes]
            deflections[tip.number] = tip.axes @ (directors @ (x - phi) - tip.xi)
        return deflections


def tip_channel(tips: Tips) -> Channel:
    """Lengths of the deflections."""
    columns = tuple(names.TIP_DEFLECTION(tip=tip.name) for tip in tips.tips)
    return Channel(columns, lambda s: np.linalg.norm(tips.at(s), axis=1).tolist())


def stress_channel(system: MultibodySystem) -> Channel:
    """Largest norm of the Cauchy stress at any cell centre. Collective."""
    blocks = [on_mesh(model, "stresses") for model in system.flexible_models]

    def values(s: Snapshot) -> list[float]:
        norms = (
            np.max(block.cauchy_stress_norm(u), initial=0.0)
            for block, u in zip(blocks, s.state.u, strict=True)
        )
        return [largest_of_ranks(system.comm, float(max(norms, default=0.0)))]

    return Channel((names.MAX_STRESS,), values)
