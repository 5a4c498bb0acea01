"""Deflection of points of flexible bodies relative to a rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import GROUND, RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts, check_array, check_vectors
from turbine_fenicsx.foundation.parallel import largest_of_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.probe import Probe, find_model
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.cell_centres import CellCentres
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.nearest_node import find_nearest_node
from turbine_fenicsx.system.state import State
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
        self.tips, rows = tuple(tips), []
        for tip in self.tips:
            whose = f"tip {tip.name!r}"
            if tip.carrier is not None:
                check_among_parts("body", tip.carrier, system.rigid_bodies, whose)
            _, row = find_nearest_node(find_model(system, tip.body, whose), tip.point)
            rows.append((tip.body, row))
        self._probe = Probe(system, rows)
        self.starts: Array = self._probe.start
        self._snapshot: Snapshot | None = None
        self._found = self.starts
        self._frames = [
            _find_frame(system, tip, X) for tip, X in zip(self.tips, self.starts, strict=True)
        ]

    def at(self, snapshot: Snapshot) -> Array:
        """Deflections at a snapshot [m], shape (n, 3), equal on all ranks. Collective."""
        if snapshot is not self._snapshot:
            self._snapshot, self._found = snapshot, self.find(snapshot.state)
        return self._found

    def find(self, state: State) -> Array:
        """Deflections in a state [m], shape (n, 3), equal on all ranks. Collective."""
        x, found = self._probe.values(state), np.empty_like(self.starts)
        for k, (coordinates, xi, axes) in enumerate(self._frames):
            q = GROUND if coordinates is None else state.q[coordinates]
            found[k] = axes @ (q[3:].reshape(3, 3) @ (x[k] - q[:3]) - xi)
        return found


def _find_frame(system: MultibodySystem, tip: Tip, X: Array) -> tuple[slice | None, Array, Array]:
    """Coordinates of the carrier of a tip, its place in the frame of these, and its axes there."""
    R, xi, coordinates = np.eye(3), X, None
    if tip.carrier is not None:
        first = system.first_coordinate[tip.carrier]
        R, coordinates = np.asarray(tip.carrier.directors, dtype=float), slice(first, first + 12)
        xi = tip.carrier.body_coordinates(X)
    axes = np.eye(3) if tip.axes is None else np.asarray(tip.axes, dtype=float) @ R
    return coordinates, xi, axes


def tip_channel(tips: Tips) -> Channel:
    """Lengths of the deflections."""
    columns = tuple(names.TIP_DEFLECTION(tip=tip.name) for tip in tips.tips)
    return Channel(columns, lambda s: np.linalg.norm(tips.at(s), axis=1).tolist())


def stress_channel(system: MultibodySystem) -> Channel:
    """Largest norm of the Cauchy stress at any cell centre. Collective."""
    models = [on_mesh(model, "stresses") for model in system.flexible_models]
    bodies = [CellCentres(model) for model in models]

    def values(s: Snapshot) -> list[float]:
        norms = (
            np.max(body.stresses(u)[0], initial=0.0)
            for body, u in zip(bodies, s.state.u, strict=True)
        )
        return [largest_of_ranks(system.comm, float(max(norms, default=0.0)))]

    return Channel((names.MAX_STRESS,), values)
