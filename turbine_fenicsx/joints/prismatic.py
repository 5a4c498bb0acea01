"""Prismatic joint: free to slide along an axis, nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.joints.coordinates import Displacement, JointCoordinate
from turbine_fenicsx.joints.two_body import AxisJoint


@dataclass(frozen=True, eq=False)
class Prismatic(AxisJoint):
    """Prismatic joint with the displacement as its joint coordinate.

    The five constraints keep the axis n of ``second`` normal to t1 and t2 of ``first``, its t1
    normal to t2 of ``first``, and its joint point on the axis of ``first``. The coordinate is the
    displacement [m] of ``second`` relative to ``first`` along the axis, zero initially.

    Its arguments are those of `AxisJoint`.
    """

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Five functions that vanish: no rotation [-], common axis [m]."""
        t1, t2, n = self.frame
        gap, n_b = self.gap(a, b), b.direction(n)
        t1_a, t2_a = a.direction(t1), a.direction(t2)
        no_rotation = [dot(n_b, t1_a), dot(n_b, t2_a), dot(b.direction(t1), t2_a)]
        return [*no_rotation, dot(gap, t1_a), dot(gap, t2_a)]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Displacement along the axis."""
        if not self.with_coordinates:
            return {}
        return {self.name: Displacement(dot(self.gap(a, b), a.direction(self.frame[2])))}
