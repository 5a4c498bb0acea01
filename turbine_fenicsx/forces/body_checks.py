"""Checks of the bodies that forces act on."""

from __future__ import annotations

from typing import Any

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError


def check_body(name: str, body: Any) -> None:
    """Raise a TypeError unless a body is a rigid one."""
    if not isinstance(body, RigidBody):
        raise TypeError(f"{name!r} needs a rigid body, got {describe(body)}")


def check_ends(name: str, first: Any, second: Any) -> None:
    """Raise unless two ends are on different rigid bodies, one of which may be the ground."""
    for body in (first, second):
        if body is not None:
            check_body(name, body)
    if first is second:
        where = "the ground" if first is None else repr(first.name)
        raise ModelError(f"both ends of {name!r} are on {where}")
