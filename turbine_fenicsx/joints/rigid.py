"""Rigid joint: two bodies that move as one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.joints.two_body import TwoBodyJoint


@dataclass(frozen=True, eq=False)
class Rigid(TwoBodyJoint):
    """Rigid joint: six constraints, no relative motion and no joint coordinates.

    Its arguments are those of `TwoBodyJoint`.
    """

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Six functions that vanish: common point [m], common directions e1, e2, e3 [-]."""
        e = np.eye(3)
        turned = [dot(b.direction(e[i]), a.direction(e[(i + 1) % 3])) for i in range(3)]
        return [*self.gap(a, b).components(), *turned]
