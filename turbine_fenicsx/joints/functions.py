"""Constraints and joint coordinates of a joint, checked: they are functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import name_errors
from turbine_fenicsx.foundation.quadratic import Quadratic
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import Angle, Displacement, JointCoordinate
from turbine_fenicsx.joints.rheonomic import Rheonomic


def find_functions(
    joint: Joint, a: BodyFrame, b: BodyFrame
) -> tuple[Sequence[Quadratic | Rheonomic], Mapping[str, JointCoordinate]]:
    """The constraints and the joint coordinates of a joint."""
    who = describe(joint)
    with name_errors(f"constraints() of {who}"):
        constraints = list(joint.constraints(a, b))
    with name_errors(f"coordinates() of {who}"):
        coordinates = dict(joint.coordinates(a, b))
    for found in constraints:
        functions = found[:1] if isinstance(found, Rheonomic) else (found,)
        _check(f"constraints() of {who}", functions, "Quadratic or Rheonomic functions")
    for name, coordinate in coordinates.items():
        what = f"coordinates() of {who} at {name!r}"
        if not isinstance(coordinate, Angle | Displacement):
            raise ModelError(f"{what} must be an Angle or a Displacement, {_got(coordinate)}")
        _check(what, coordinate, "made of Quadratic functions")
    return constraints, coordinates


def _check(what: str, found: Sequence[Any], words: str) -> None:
    """Raise a ModelError unless all are functions of the coordinates."""
    for function in found:
        if not isinstance(function, Quadratic):
            raise ModelError(
                f"{what} must be {words}, such as dot(v, w) and the components of an AffineVector, "
                f"{_got(function)}"
            )


def _got(found: Any) -> str:
    """The end of a sentence about something wrong."""
    return f"got {describe(found)}"
