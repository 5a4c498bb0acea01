"""Cylindrical joint: a common axis, free to turn about it and to slide along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.joints.coordinates import Displacement, JointCoordinate, angle_between
from turbine_fenicsx.joints.two_body import AxisJoint


@dataclass(frozen=True, eq=False)
class Cylindrical(AxisJoint):
    """Cylindrical joint with two joint coordinates.

    The four constraints keep the axis n of ``second`` normal to t1 and t2 of ``first``, and the
    joint point of ``second`` on the axis of ``first``. The coordinates are ``NAME.angle`` [rad] of
    ``second`` relative to ``first`` about the axis, and ``NAME.displacement`` [m] along it; both
    are zero initially.

    Its arguments are those of `AxisJoint`.
    """

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Four functions that vanish: parallel axes [-], common axis [m]."""
        t1, t2, n = self.frame
        gap, n_b = self.gap(a, b), b.direction(n)
        t1_a, t2_a = a.direction(t1), a.direction(t2)
        return [dot(n_b, t1_a), dot(n_b, t2_a), dot(gap, t1_a), dot(gap, t2_a)]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Angle about and displacement along the axis."""
        if not self.with_coordinates:
            return {}
        t1, t2, n = self.frame
        return {
            f"{self.name}.angle": angle_between(a.direction(t1), a.direction(t2), b.direction(t1)),
            f"{self.name}.displacement": Displacement(dot(self.gap(a, b), a.direction(n))),
        }
