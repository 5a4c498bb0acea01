"""Code of users, such as their forces and motions: its errors become a sentence on all ranks.

Such code may fail on one rank alone, or give other numbers on each. So rank 0 evaluates it for all,
except in steps of rigid bodies, which rank 0 takes alone.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from types import TracebackType
from typing import Any, TypeVar

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import (
    CompilationError,
    FileError,
    ForeignError,
    InputError,
    StepFailure,
)
from turbine_fenicsx.foundation.parallel import on_rank0

T = TypeVar("T")

_PACKAGE = __name__.partition(".")[0]

_SENTENCES = (InputError, StepFailure, CompilationError, FileError, MemoryError)

PRINT_TIME = 0.5
"""Time in which all ranks print an error before they end [s]."""

_MAX_LENGTH = 300
"""Letters of an error's text."""


def name_error(what: str, error: Exception) -> Exception:
    """The error of some code with its name; an error that is a sentence of ours stays as it is."""
    if isinstance(error, _SENTENCES):
        return error
    return ForeignError(f"{what} failed: {describe_error(error)}")


@contextmanager
def name_errors(what: str) -> Iterator[None]:
    """Name the code inside if it raises an error, see `name_error`."""
    try:
        with name_exits(what):
            yield
    except Exception as error:
        raise name_error(what, error) from error


@contextmanager
def name_exits(what: str) -> Iterator[None]:
    """Let code that ends the program raise an error instead: other ranks would wait for ever."""
    try:
        yield
    except SystemExit as end:
        raise ForeignError(f"{what} failed: it ends the program by sys.exit({end.code})") from end


def end_all_on_error(comm: MPI.Intracomm) -> None:
    """Let an error that ends a script on one rank end all of them, which would wait for ever."""

    def end_all(
        kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        sys.__excepthook__(kind, error, trace)
        sys.stdout.flush()
        sys.stderr.flush()
        time.sleep(PRINT_TIME)  # the other ranks print the same error, if it is one of all
        comm.Abort(1)

    if comm.size > 1 and sys.excepthook is sys.__excepthook__:
        sys.excepthook = end_all


def is_of_package(thing: Any) -> bool:
    """Whether a function, or an object with the functions in it, has no code of a user."""
    owner = thing if hasattr(thing, "__name__") else type(thing)
    if str(getattr(owner, "__module__", "")).partition(".")[0] != _PACKAGE:
        return False
    inner = [getattr(thing, x.name) for x in fields(thing)] if is_dataclass(thing) else []
    return all(is_of_package(part) for part in inner if callable(part))


def on_rank0_if_own(comm: MPI.Intracomm, things: Any, evaluate: Callable[[], T]) -> T:
    """The result of a function, that of rank 0 on all ranks if code of a user takes part in it.

    Note:
        Collective.
    """
    if comm.size == 1 or all(is_of_package(thing) for thing in things):
        return evaluate()
    return on_rank0(comm, evaluate)


def evaluate_function(
    comm: MPI.Intracomm, what: str, function: Callable[[float], float], time: float
) -> float:
    """The value of a function of time, the same on all ranks. Collective.

    Args:
        time: Time [s].
    """

    def evaluate() -> float:
        with name_errors(f"{what}, {describe_kind(function)}, at t = {time:g} s"):
            return float(function(time))

    return on_rank0_if_own(comm, [function], evaluate)


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
