"""Planar joint: free to slide in a plane and to turn about its normal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.argument_checks import check_directions
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.joints.coordinates import Displacement, JointCoordinate, angle_between
from turbine_fenicsx.joints.two_body import TwoBodyJoint


@dataclass(frozen=True, eq=False)
class Planar(TwoBodyJoint):
    """Planar joint with three joint coordinates.

    The three constraints keep the normal n of ``second`` normal to t1 and t2 of ``first``, and its
    joint point in the plane of ``first``. The coordinates are the displacements ``NAME.first`` and
    ``NAME.second`` [m] along t1 and t2 of ``first``, and ``NAME.angle`` [rad] about n; all are zero
    initially.

    Args:
        name, first, second, point: As of `TwoBodyJoint`.
        normal: Normal of the plane in the initial configuration, shape (3,).
        reference: Direction of t1 in the plane, shape (3,); any if None.
        with_coordinates: Whether the joint coordinates are coordinates of the system.

    Raises:
        ModelError: if the point or the normal is not three numbers, or the normal is zero.
    """

    _: KW_ONLY
    normal: npt.ArrayLike
    reference: npt.ArrayLike | None = None
    with_coordinates: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_directions(self.name, normal=self.normal)
        if self.reference is not None:
            check_directions(self.name, reference=self.reference)

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Three functions that vanish: parallel normals [-], distance to the plane [m]."""
        t1, t2, n = frame_with_axis(self.normal, self.reference).T
        gap, n_b = self.gap(a, b), b.direction(n)
        return [dot(n_b, a.direction(t1)), dot(n_b, a.direction(t2)), dot(gap, a.direction(n))]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Displacements in the plane and angle about its normal."""
        if not self.with_coordinates:
            return {}
        t1, t2, _ = frame_with_axis(self.normal, self.reference).T
        gap, t1_a, t2_a = self.gap(a, b), a.direction(t1), a.direction(t2)
        return {
            f"{self.name}.first": Displacement(dot(gap, t1_a)),
            f"{self.name}.second": Displacement(dot(gap, t2_a)),
            f"{self.name}.angle": angle_between(t1_a, t2_a, b.direction(t1)),
        }
