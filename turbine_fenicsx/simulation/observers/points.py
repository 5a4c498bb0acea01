"""Position and velocity of material points of rigid and flexible bodies.

A point X of a flexible body is at X + sum_a N_a(X) u_a, with the shape functions N_a of the cell
that holds it, which are evaluated once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts, check_vectors, describe
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.probe import Probe, find_model, find_point
from turbine_fenicsx.simulation.snapshot import Snapshot
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
        bodies = [*system.rigid_bodies, *system.flexible_bodies]
        for point in self.points:
            check_among_parts("body", point.body, bodies, f"point {point.name!r}")
        self._probe = Probe(system, [(p.body, _find_row(system, p)) for p in self.points])

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
        return self._probe.motion(state)


def point_channel(points: Points) -> Channel:
    """Position and velocity of each point, three columns each."""
    columns = tuple(
        family(point=point.name, axis=i)
        for point in points.points
        for family in (names.POSITION, names.VELOCITY)
        for i in (1, 2, 3)
    )
    return Channel(columns, lambda s: points.at(s).ravel().tolist())


def _find_row(system: MultibodySystem, point: Point) -> csr_matrix:
    """Row of a point. Collective."""
    X, body = np.asarray(point.position, dtype=float), point.body
    if isinstance(body, RigidBody):
        return csr_matrix([[1.0, *body.body_coordinates(X)]])
    return find_point(find_model(system, body, ""), X, point.name)
