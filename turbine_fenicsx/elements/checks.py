"""Checks of what users give to force elements and loads: one sentence each."""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx.rigid_body import RigidBody


def check_not_negative(name: str, what: str, value: float) -> None:
    """Raise a ValueError for a negative or infinite stiffness, damping or length."""
    if not 0.0 <= value < np.inf:
        raise ValueError(f"{what} of {name!r} must not be negative, got {value:g}")


def check_vectors(name: str, **vectors: Any) -> None:
    """Raise a ValueError unless each of the vectors has three finite components."""
    for what, vector in vectors.items():
        v = np.asarray(vector, dtype=float)
        if v.shape != (3,) or not np.all(np.isfinite(v)):
            words = what.replace("_", " ")
            raise ValueError(f"{words} of {name!r} must be three numbers, got {vector!r}")


def check_function(name: str, function: Any) -> None:
    """Raise a TypeError unless a function of time can be called."""
    if not callable(function):
        raise TypeError(
            f"{name!r} needs a function of time, for example Constant({function!r}), "
            f"but {function!r} is none"
        )


def check_body(name: str, body: Any) -> None:
    """Raise a TypeError unless a body is a rigid one."""
    if not isinstance(body, RigidBody):
        raise TypeError(f"{name!r} needs a rigid body, but {getattr(body, 'name', body)!r} is none")


def check_ends(name: str, first: Any, second: Any) -> None:
    """Raise an error unless two ends are on different rigid bodies, one of which may be the ground.

    Raises:
        TypeError: if one is neither a rigid body nor None.
        ValueError: if both are the same.
    """
    for body in (first, second):
        if body is not None:
            check_body(name, body)
    if first is second:
        where = "the ground" if first is None else repr(first.name)
        raise ValueError(f"both ends of {name!r} are on {where}")
