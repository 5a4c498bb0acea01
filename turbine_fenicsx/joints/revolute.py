"""Revolute joint: a common point and a common axis, one free rotation, eq. (12)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.joints.coordinates import JointCoordinate, angle_between
from turbine_fenicsx.joints.two_body import AxisJoint


@dataclass(frozen=True, eq=False)
class Revolute(AxisJoint):
    """Revolute joint with an augmented joint angle, eqs (12), (15)-(18).

    The five constraints are: three for the common point, and two for the axis of ``second``,
    which stays normal to two directions t1, t2 of ``first``. The angle of ``second`` relative to
    ``first`` counts positive about ``axis`` and is zero initially; cos = t1_a . t1_b and
    sin = t2_a . t1_b.

    Its arguments are those of `AxisJoint`.
    """

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Five functions that vanish: common point [m], common axis [-]."""
        # eq. (12)
        t1, t2, n = self.frame
        n_b = b.direction(n)
        return [*self.gap(a, b).components(), dot(n_b, a.direction(t1)), dot(n_b, a.direction(t2))]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """The joint angle, eq. (16)."""
        if not self.with_coordinates:
            return {}
        t1, t2, _ = self.frame
        return {self.name: angle_between(a.direction(t1), a.direction(t2), b.direction(t1))}
