"""Prismatic joint: free to slide along an axis, nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.checks import check_directions, check_vectors
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.joints.coordinates import Displacement, JointCoordinate


@dataclass(frozen=True, eq=False)
class Prismatic:
    """Prismatic joint with the displacement as its joint coordinate.

    The five constraints keep the axis n of ``second`` normal to t1 and t2 of ``first``, its t1
    normal to t2 of ``first``, and its joint point on the axis of ``first``. The coordinate is the
    displacement [m] of ``second`` relative to ``first`` along the axis, zero initially.

    Args:
        name: Unique name.
        first: First partner, None for the ground.
        second: Second partner.
        point: Joint point in the initial configuration [m], shape (3,).
        axis: Joint axis in the initial configuration, shape (3,).
        with_coordinates: Whether the joint coordinates are coordinates of the system.

    Raises:
        ModelError: for a point or an axis that is no three numbers, or no direction.
    """

    name: str
    first: RigidBody | None
    second: RigidBody | None
    _: KW_ONLY
    point: npt.ArrayLike
    axis: npt.ArrayLike
    with_coordinates: bool = True

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point)
        check_directions(self.name, axis=self.axis)

    @property
    def bodies(self) -> tuple[RigidBody | None, RigidBody | None]:
        """The two partners; None is the ground."""
        return self.first, self.second

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Five functions that vanish: no rotation [-], common axis [m]."""
        t1, t2, n = frame_with_axis(self.axis).T
        gap, n_b = b.point(self.point) - a.point(self.point), b.direction(n)
        t1_a, t2_a = a.direction(t1), a.direction(t2)
        no_rotation = [dot(n_b, t1_a), dot(n_b, t2_a), dot(b.direction(t1), t2_a)]
        return [*no_rotation, dot(gap, t1_a), dot(gap, t2_a)]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Displacement along the axis."""
        if not self.with_coordinates:
            return {}
        n = frame_with_axis(self.axis)[:, 2]
        gap = b.point(self.point) - a.point(self.point)
        return {self.name: Displacement(dot(gap, a.direction(n)))}
