"""Rigid joint: two bodies that move as one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.checks import check_vectors
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.joints.coordinates import JointCoordinate


@dataclass(frozen=True, eq=False)
class Rigid:
    """Rigid joint: six constraints, no relative motion and no joint coordinates.

    Args:
        name: Unique name.
        first: First partner, None for the ground.
        second: Second partner.
        point: Joint point in the initial configuration [m], shape (3,).

    Raises:
        ModelError: for a point that is no three numbers.
    """

    name: str
    first: RigidBody | None
    second: RigidBody | None
    point: npt.ArrayLike

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point)

    @property
    def bodies(self) -> tuple[RigidBody | None, RigidBody | None]:
        """The two partners; None is the ground."""
        return self.first, self.second

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Six functions that vanish: common point [m], common directions e1, e2, e3 [-]."""
        gap = b.point(self.point) - a.point(self.point)
        e = np.eye(3)
        turned = [dot(b.direction(e[i]), a.direction(e[(i + 1) % 3])) for i in range(3)]
        return [*gap.components(), *turned]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """It has no joint coordinates."""
        return {}
