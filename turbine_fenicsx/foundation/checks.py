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
        what: What they are, for the message.
        value: What was given.
        shape: The shape they must have.
        words: What is wanted, for the message.

    Returns:
        The numbers, of that shape.

    Raises:
        ModelError: for another shape, or for what is no finite number.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):  # text, nothing, lists of different lengths
        array = np.zeros(0)
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


def check_among_parts(what: str, part: Any, parts: Sequence[Any]) -> None:
    """Raise a ModelError unless a body, joint or coupling is one of those of a system."""
    if part not in parts:
        raise ModelError(f"{what} is not among the parts")


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
    """What was given in place of something else, for messages: its type and its name or value."""
    if value is None:
        return "None"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = getattr(value, "name", None)
    text = repr(name if isinstance(name, str) else value)
    kind = type(value).__name__
    return f"{kind} {text}" if len(text) <= 60 else f"an object of type {kind}"


def _number(value: Any) -> float:
    """The number, or nan for what is none."""
    try:
        return float(value) if np.ndim(value) == 0 else np.nan
    except (TypeError, ValueError):
        return np.nan
