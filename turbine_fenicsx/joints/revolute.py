"""Revolute joint: a common point and a common axis, one free rotation, eq. (12)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.checks import check_directions, check_vectors
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.joints.coordinates import JointCoordinate, angle_between


@dataclass(frozen=True, eq=False)
class Revolute:
    """Revolute joint with an augmented joint angle, eqs (12), (15)-(18).

    The five constraints are: three for the common point, and two for the axis of ``second``,
    which stays normal to two directions t1, t2 of ``first``. The angle of ``second`` relative to
    ``first`` counts positive about ``axis`` and is zero initially; cos = t1_a . t1_b and
    sin = t2_a . t1_b.

    Args:
        name: Unique name; the angle is reported under it.
        first: First partner, None for the ground.
        second: Second partner.
        point: Joint point in the initial configuration [m], shape (3,).
        axis: Joint axis in the initial configuration, shape (3,).
        reference: Direction of t1, shape (3,); any normal to the axis if None.
        with_coordinates: Whether the joint angle is a coordinate of the system.

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
        """Five functions that vanish: common point [m], common axis [-]."""
        t1, t2, n = frame_with_axis(self.axis, self.reference).T
        gap = b.point(self.point) - a.point(self.point)
        n_b = b.direction(n)
        return [*gap.components(), dot(n_b, a.direction(t1)), dot(n_b, a.direction(t2))]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """The joint angle, eq. (16)."""
        if not self.with_coordinates:
            return {}
        t1, t2, _ = frame_with_axis(self.axis, self.reference).T
        return {self.name: angle_between(a.direction(t1), a.direction(t2), b.direction(t1))}
