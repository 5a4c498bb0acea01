"""Cylindrical joint: a common axis, free to turn about it and to slide along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.checks import check_directions, check_vectors
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.joints.coordinates import Displacement, JointCoordinate, angle_between


@dataclass(frozen=True, eq=False)
class Cylindrical:
    """Cylindrical joint with two joint coordinates.

    The four constraints keep the axis n of ``second`` normal to t1 and t2 of ``first``, and the
    joint point of ``second`` on the axis of ``first``. The coordinates are ``NAME.angle`` [rad] of
    ``second`` relative to ``first`` about the axis, and ``NAME.displacement`` [m] along it; both
    are zero initially.

    Args:
        name: Unique name.
        first: First partner, None for the ground.
        second: Second partner.
        point: Joint point in the initial configuration [m], shape (3,).
        axis: Joint axis in the initial configuration, shape (3,).
        reference: Direction of t1, shape (3,); any normal to the axis if None.
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
    reference: npt.ArrayLike | None = None
    with_coordinates: bool = True

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point)
        check_directions(self.name, axis=self.axis)
        if self.reference is not None:
            check_directions(self.name, reference=self.reference)

    @property
    def bodies(self) -> tuple[RigidBody | None, RigidBody | None]:
        """The two partners; None is the ground."""
        return self.first, self.second

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Four functions that vanish: parallel axes [-], common axis [m]."""
        t1, t2, n = frame_with_axis(self.axis, self.reference).T
        gap, n_b = b.point(self.point) - a.point(self.point), b.direction(n)
        t1_a, t2_a = a.direction(t1), a.direction(t2)
        return [dot(n_b, t1_a), dot(n_b, t2_a), dot(gap, t1_a), dot(gap, t2_a)]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Angle about and displacement along the axis."""
        if not self.with_coordinates:
            return {}
        t1, t2, n = frame_with_axis(self.axis, self.reference).T
        gap = b.point(self.point) - a.point(self.point)
        return {
            f"{self.name}.angle": angle_between(a.direction(t1), a.direction(t2), b.direction(t1)),
            f"{self.name}.displacement": Displacement(dot(gap, a.direction(n))),
        }
