"""Base classes of joints at a point of two bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.argument_checks import check_directions, check_vectors
from turbine_fenicsx.foundation.quadratic import AffineVector
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.coordinates import JointCoordinate


@dataclass(frozen=True, eq=False)
class TwoBodyJoint:
    """Base of joints at a common point of two bodies; without joint coordinates.

    Args:
        name: Unique name.
        first: First partner, None for the ground.
        second: Second partner.
        point: Joint point in the initial configuration [m], shape (3,).

    Raises:
        ModelError: if the point is not three numbers.
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

    def gap(self, a: BodyFrame, b: BodyFrame) -> AffineVector:
        """Vector from the joint point of ``first`` to that of ``second`` [m]."""
        return b.point(self.point) - a.point(self.point)

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """It has no joint coordinates."""
        return {}


@dataclass(frozen=True, eq=False)
class AxisJoint(TwoBodyJoint):
    """Base of joints with a common axis n and two directions t1, t2 normal to it.

    Args:
        first: First partner, None for the ground.
        point: Joint point in the initial configuration [m], shape (3,).
        axis: Joint axis in the initial configuration, shape (3,).
        reference: Direction of t1, shape (3,); any normal to the axis if None.
        with_coordinates: Whether the joint coordinates are coordinates of the system.
    """

    _: KW_ONLY
    axis: npt.ArrayLike
    reference: npt.ArrayLike | None = None
    with_coordinates: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_directions(self.name, axis=self.axis)
        if self.reference is not None:
            check_directions(self.name, reference=self.reference)

    @property
    def frame(self) -> Array:
        """Rows t1, t2, n, shape (3, 3)."""
        return frame_with_axis(self.axis, self.reference).T
