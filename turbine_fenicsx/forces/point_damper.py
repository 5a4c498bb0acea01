"""Linear damper between two material points."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_ends
from turbine_fenicsx.forces.force import BoundForce, DistanceForce, Kind, Layout
from turbine_fenicsx.foundation.argument_checks import check_not_negative, check_vectors


@dataclass(frozen=True, eq=False)
class PointDamper:
    """A force -d (l_1 - l_0)/dt along the line of two points at the distance l.

    With f = l^2 the discrete gradient of l is grad f/(l_0 + l_1) at the midpoint, so that a step
    dissipates exactly d (l_1 - l_0)^2/dt, and the force has neither resultant nor moment.

    Args:
        name: Unique name.
        first: First body, None for the ground.
        second: Second body, None for the ground.
        first_point: Point of the first body in the initial configuration [m], shape (3,).
        second_point: Point of the second body in the initial configuration [m], shape (3,).
        damping: d, not negative [N s/m].

    Raises:
        ModelError: for a negative damping, points that are not three numbers, or two points
            of the same body.
        TypeError: if a partner is no rigid body.
    """

    name: str
    first: RigidBody | None
    second: RigidBody | None
    _: KW_ONLY
    first_point: npt.ArrayLike
    second_point: npt.ArrayLike
    damping: float
    kind: Kind = "dissipative"

    def __post_init__(self) -> None:
        check_ends(self.name, self.first, self.second)
        check_vectors(self.name, first_point=self.first_point, second_point=self.second_point)
        check_not_negative(f"damping of {self.name!r}", self.damping)

    def bind(self, layout: Layout) -> BoundForce:
        """The damper with its coordinates numbered."""
        (a, b), index = layout.frames(self.first, self.second)
        gap = b.point(self.second_point) - a.point(self.first_point)
        d = self.damping

        def law(f0: float, f1: float, dt: float) -> tuple[float, float]:
            l0, l1 = np.sqrt(f0), np.sqrt(f1)
            if l0 + l1 == 0.0:
                return 0.0, 0.0
            h = -d / dt * (l1 - l0) / (l0 + l1)
            return h, -d / dt * l0 / (l1 * (l0 + l1) ** 2) if l1 else 0.0

        return DistanceForce(gap, index, law)
