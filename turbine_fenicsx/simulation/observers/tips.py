"""Deflection of points of flexible bodies relative to a rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.nearest_node import nearest_node
from turbine_fenicsx.bodies.rigid_body import GROUND, RigidBody
from turbine_fenicsx.foundation.checks import check_among_parts, check_array, check_vectors
from turbine_fenicsx.foundation.parallel import largest_of_ranks, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Tip:
    """A point to follow.

    Args:
        name: Column ``tip_deflection_NAME_[m]``.
        body: Flexible body; its node nearest to the point is followed.
        point: Initial position [m], shape (3,).
        carrier: Rigid body whose frame the deflection is measured in; None is the ground.
        axes: Axes of the components, fixed to the parent body; their initial directions as rows,
            shape (3, 3). The directors of the parent body if None, e1, e2, e3 on the ground.
    """

    name: str
    body: FlexibleBody
    point: npt.ArrayLike
    carrier: RigidBody | None
    axes: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point)
        if self.axes is not None:
            check_array(f"axes of {self.name!r}", self.axes, (3, 3), "three rows of three numbers")


class Tips:
    """Deflections R^T (x - phi) - xi of points in the frames of their parent bodies.

    Args:
        system: The system.
        tips: The points.

    Raises:
        ModelError: for a body or parent body that is not part of the system.

    Note:
        Collective.
    """

    def __init__(self, system: MultibodySystem, tips: Sequence[Tip]) -> None:
        self._comm = comm = system.comm
        self.tips = tuple(tips)
        self._mine: list[tuple[int, int, slice, slice | None, Array, Array, Array]] = []
        for k, tip in enumerate(self.tips):
            whose = f"tip {tip.name!r}"
            check_among_parts("body", tip.body, system.flexible_bodies, whose)
            if tip.carrier is not None:
                check_among_parts("body", tip.carrier, system.rigid_bodies, whose)
            index = system.flexible_bodies.index(tip.body)
            block = on_mesh(system.flexible_models[index], "tips")
            node = nearest_node(comm, block.positions, tip.point)
            if node is not None:
                X, axes, R = block.positions[node], np.eye(3), np.eye(3)
                xi, q = X, None
                if tip.carrier is not None:
                    first = system.first_coordinate[tip.carrier]
                    xi, q = tip.carrier.body_coordinates(X), slice(first, first + 12)
                    R = np.asarray(tip.carrier.directors, dtype=float)
                if tip.axes is not None:
                    axes = np.asarray(tip.axes, dtype=float) @ R
                dofs = slice(3 * node, 3 * node + 3)
                self._mine.append((k, index, dofs, q, X, xi, axes))

    def at(self, snapshot: Snapshot) -> Array:
        """Deflections at a snapshot [m], shape (n, 3), equal on all ranks. Collective."""
        return sum_over_ranks(self._comm, self._local(snapshot))

    def _local(self, snapshot: Snapshot) -> Array:
        """Deflections of the nodes of this rank, zero for the others."""
        deflections = np.zeros((len(self.tips), 3))
        state = snapshot.state
        for k, index, dofs, coordinates, X, xi, axes in self._mine:
            q = GROUND if coordinates is None else state.q[coordinates]
            phi, directors = q[:3], q[3:].reshape(3, 3)
            x = X + state.u[index].array_r[dofs]
            deflections[k] = axes @ (directors @ (x - phi) - xi)
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
