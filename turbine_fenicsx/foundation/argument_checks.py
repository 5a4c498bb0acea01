"""Checks of the arguments of a model's parts, with one sentence per mistake."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


def check_array(what: str, value: Any, shape: tuple[int, ...], words: str) -> Array:
    """Finite numbers of a given shape.

    Args:
        shape: The shape they must have.

    Returns:
        The numbers, of that shape.
    """
    array = _as_floats(value)
    if array.shape != shape or not np.all(np.isfinite(array)):
        got = repr(value) if array.size < 10 else f"an array of shape {array.shape}"
        raise ModelError(f"{what} must be {words}, got {got}")
    return array


def check_vectors(name: str, **vectors: Any) -> None:
    """Raise a ModelError unless each of the vectors has three finite components."""
    for what, vector in vectors.items():
        words = what.replace("_", " ")
        check_array(f"{words} of {name!r}", vector, (3,), "three numbers")


def check_directions(name: str, **directions: Any) -> None:
    """Raise a ModelError unless each of the vectors has a direction."""
    for what, direction in directions.items():
        what = f"{what.replace('_', ' ')} of {name!r}"
        words = "a direction, three numbers that are not all zero"
        if not np.any(check_array(what, direction, (3,), words)):
            raise ModelError(f"{what} must be {words}, got {direction!r}")


def check_among_parts(what: str, part: Any, parts: Sequence[Any], of: str = "") -> None:
    """Raise a ModelError unless a part is one of those of a system.

    Args:
        what: What kind of part it is, for the message.
        parts: Those of its kind in the system.
        of: What it belongs to, for the message.
    """
    if part not in parts:
        whose = f" of {of}" if of else ""
        raise ModelError(f"{what} {part.name!r}{whose} is not among the parts")


def check_number(what: str, value: Any) -> float:
    """A finite number; a ModelError for anything else."""
    number = _number(value)
    if not np.isfinite(number):
        raise ModelError(f"{what} must be a number, got {value!r}")
    return number


def check_positive(what: str, value: Any) -> float:
    """A positive, finite number; a ModelError for anything else."""
    number = _number(value)
    if not 0.0 < number < np.inf:
        raise ModelError(f"{what} must be positive, got {value!r}")
    return number


def check_not_negative(what: str, value: Any) -> float:
    """A finite number, zero or more; a ModelError for anything else."""
    number = _number(value)
    if not 0.0 <= number < np.inf:
        raise ModelError(f"{what} must not be negative, got {value!r}")
    return number


def check_function(name: str, function: Any) -> None:
    """Raise a TypeError unless a function of time can be called."""
    if not callable(function):
        example = function if isinstance(function, int | float) else 1.0
        raise TypeError(
            f"{name!r} needs a function of time, for example Constant({example!r}), got "
            f"{describe(function)}"
        )


def check_methods(what: str, thing: Any, methods: Sequence[str]) -> None:
    """Raise a TypeError unless an object has some methods."""
    if isinstance(thing, type) or not all(callable(getattr(thing, m, None)) for m in methods):
        *others, last = (f"{name}()" for name in methods)
        needed = f"{', '.join(others)} and {last}" if others else last
        raise TypeError(f"{what} needs the methods {needed}, got {describe(thing)}")


def describe(value: Any) -> str:
    """Describe a wrong argument in a message: its type and its name or value."""
    if value is None:
        return "None"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = getattr(value, "name", None)
    text = repr(name if isinstance(name, str) else value)
    kind = type(value).__name__
    return f"{kind} {text}" if len(text) <= 60 else f"an object of type {kind}"


def _number(value: Any) -> float:
    """The number, or nan if it is not one."""
    array = _as_floats(value)
    return float(array) if array.ndim == 0 else np.nan


def _as_floats(value: Any) -> Array:
    """An array of numbers; an empty one for text, nothing, and lists of different lengths."""
    try:
        array = np.asarray(value)
        return np.zeros(0) if array.dtype.kind in "USc" else array.astype(float)
    except (TypeError, ValueError):
        return np.zeros(0)
