"""Universal joint (Cardan): a common point and two perpendicular axes, one in each body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.argument_checks import check_directions
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.quadratic import Quadratic, dot
from turbine_fenicsx.foundation.rotations import unit
from turbine_fenicsx.joints.coordinates import Angle, JointCoordinate, angle_between
from turbine_fenicsx.joints.two_body import TwoBodyJoint


@dataclass(frozen=True, eq=False)
class Universal(TwoBodyJoint):
    """Universal joint with two joint coordinates.

    The four constraints are three for the common point, and one that keeps ``second_axis``, fixed
    in ``second``, normal to ``first_axis``, fixed in ``first``. The coordinates are the angles
    ``NAME.first`` [rad] of the cross relative to ``first`` about ``first_axis``, and
    ``NAME.second`` [rad] of ``second`` relative to the cross about ``second_axis``; both are zero
    initially.

    Args:
        name, first, second, point: As of `TwoBodyJoint`.
        first_axis: Axis fixed in ``first``, initial direction, shape (3,).
        second_axis: Axis fixed in ``second``, initial direction, shape (3,), normal to the other.
        with_coordinates: Whether the joint coordinates are coordinates of the system.

    Raises:
        ModelError: if the axes are not perpendicular, or a point or axis is no three numbers.
    """

    _: KW_ONLY
    first_axis: npt.ArrayLike
    second_axis: npt.ArrayLike
    with_coordinates: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_directions(self.name, first_axis=self.first_axis, second_axis=self.second_axis)
        n1, n2 = unit(self.first_axis), unit(self.second_axis)
        if abs(n1 @ n2) > 1e-9:
            raise ModelError(
                f"axes of universal joint {self.name!r} must be perpendicular, got "
                f"{self.first_axis!r} and {self.second_axis!r}"
            )

    def constraints(self, a: BodyFrame, b: BodyFrame) -> list[Quadratic]:
        """Four functions that vanish: common point [m], perpendicular axes [-]."""
        gap = self.gap(a, b)
        n1, n2 = unit(self.first_axis), unit(self.second_axis)
        return [*gap.components(), dot(a.direction(n1), b.direction(n2))]

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Angles about the axis in ``first`` and about that in ``second``."""
        if not self.with_coordinates:
            return {}
        n1, n2 = unit(self.first_axis), unit(self.second_axis)
        n1_a, n1_b = a.direction(n1), b.direction(n1)
        third_a, third_b = a.direction(np.cross(n1, n2)), b.direction(np.cross(n1, n2))
        return {
            f"{self.name}.first": angle_between(a.direction(n2), third_a, b.direction(n2)),
            f"{self.name}.second": Angle(dot(n1_a, n1_b), dot(n1_a, third_b)),
        }
