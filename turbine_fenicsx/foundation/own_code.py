"""Code of users, such as their forces and motions: its errors become a sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from turbine_fenicsx.foundation.errors import (
    CompilationError,
    FileError,
    ForeignError,
    InputError,
    StepFailure,
)

_SENTENCES = (InputError, StepFailure, CompilationError, FileError, MemoryError)

_MAX_LENGTH = 300
"""Letters of an error's text."""


def name_error(what: str, error: Exception) -> Exception:
    """The error of some code with its name; an error that is a sentence of ours stays as it is.

    Args:
        what: What has failed, with its class.
        error: What it has raised.
    """
    if isinstance(error, _SENTENCES):
        return error
    return ForeignError(f"{what} failed: {describe_error(error)}")


@contextmanager
def name_errors(what: str) -> Iterator[None]:
    """Name the code inside if it raises an error, see `name_error`.

    Raises:
        ForeignError: for any other error than sentences of ours.
    """
    try:
        yield
    except Exception as error:
        raise name_error(what, error) from error


def evaluate_function(what: str, function: Callable[[float], float], time: float) -> float:
    """The value of a function of time.

    Args:
        what: What it is, for the message.
        function: The function.
        time: Time [s].

    Raises:
        ForeignError: if it fails, or gives something else than a number.
    """
    try:
        return float(function(time))
    except Exception as error:
        where = f"{what}, {describe_kind(function)}, at t = {time:g} s"
        raise name_error(where, error) from error


def describe_kind(thing: Any) -> str:
    """The kind of a function or an object: "function 'speed_up'", or its class."""
    name = getattr(thing, "__name__", None)
    return f"function {name!r}" if isinstance(name, str) else type(thing).__name__


def describe_error(error: BaseException) -> str:
    """Kind and text of an error on one line, without characters that steer a terminal."""
    try:
        text = " ".join(str(error).split())[:_MAX_LENGTH]
    except BaseException:
        text = "its text cannot be had"
    return f"{type(error).__name__}{': ' if text else ''}{escape(text)}"


def escape(text: str) -> str:
    """A text whose control characters are written out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
