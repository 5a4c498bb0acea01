"""Linear spring between two material points."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_ends
from turbine_fenicsx.forces.force import BoundForce, DistanceForce, Kind, Layout
from turbine_fenicsx.foundation.argument_checks import check_not_negative, check_vectors


@dataclass(frozen=True, eq=False)
class PointSpring:
    """V = k/2 (l - L)^2 with the distance l of two points.

    The square f = l^2 is a quadratic function of the coordinates, and

        (V_1 - V_0)/(f_1 - f_0) = k/2 (1 - 2 L/(l_0 + l_1)),

    without a quotient of small numbers: an exact discrete gradient, which has neither resultant
    nor moment.

    Args:
        name: Unique name.
        first: First body, None for the ground.
        second: Second body, None for the ground.
        first_point: Point of the first body in the initial configuration [m], shape (3,).
        second_point: Point of the second body in the initial configuration [m], shape (3,).
        stiffness: k, not negative [N/m].
        length: Length L at rest, not negative [m]; the initial distance if None.

    Raises:
        ModelError: for a negative stiffness or length, points that are not three numbers, or two
            points of the same body.
        TypeError: if a partner is no rigid body.
    """

    name: str
    first: RigidBody | None
    second: RigidBody | None
    _: KW_ONLY
    first_point: npt.ArrayLike
    second_point: npt.ArrayLike
    stiffness: float
    length: float | None = None
    kind: Kind = "conservative"

    def __post_init__(self) -> None:
        check_ends(self.name, self.first, self.second)
        check_vectors(self.name, first_point=self.first_point, second_point=self.second_point)
        check_not_negative(f"stiffness of {self.name!r}", self.stiffness)
        check_not_negative(f"length of {self.name!r}", self.length or 0.0)

    def bind(self, layout: Layout) -> BoundForce:
        """The spring with its coordinates numbered."""
        (a, b), index = layout.frames(self.first, self.second)
        gap = b.point(self.second_point) - a.point(self.first_point)
        k, L = self.stiffness, self.length
        if L is None:
            points = np.subtract(self.second_point, self.first_point)
            L = float(np.linalg.norm(points))

        def law(f0: float, f1: float, dt: float) -> tuple[float, float]:
            l0, l1 = np.sqrt(f0), np.sqrt(f1)
            if L == 0.0:
                return -0.5 * k, 0.0  # linear in the coordinates
            if l0 + l1 == 0.0:
                return 0.0, 0.0  # a distance of zero has no direction
            h = -0.5 * k * (1.0 - 2.0 * L / (l0 + l1))
            return h, -0.5 * k * L / (l1 * (l0 + l1) ** 2) if l1 else 0.0

        def energy(f: float) -> float:
            return 0.5 * k * float(np.sqrt(f) - L) ** 2

        return DistanceForce(gap, index, law, energy)
