"""Spherical joint: a common point."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.quadratic import Quadratic
from turbine_fenicsx.joints.two_body import TwoBodyJoint


@dataclass(frozen=True, eq=False)
class Spherical(TwoBodyJoint):
    """Spherical joint: three constraints for the common point; no joint coordinates.

    Its arguments are those of `TwoBodyJoint`.
    """

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Three functions that vanish: common point [m]."""
        return list(self.gap(a, b).components())
