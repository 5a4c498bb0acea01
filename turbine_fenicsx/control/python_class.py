"""A controller that is a class in a Python file of the user.

The file is run as it is, with all rights of the user: naming it in a case is a decision to run it.
Exceptions of its code become a sentence with its name, file and line.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from turbine_fenicsx.control.command_check import check_commands
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.foundation.errors import ForeignError, InputError
from turbine_fenicsx.foundation.interrupts import end_if_stuck
from turbine_fenicsx.foundation.own_code import describe_error
from turbine_fenicsx.foundation.restart_data import RestartData

T = TypeVar("T")

DEPTH = 32
"""Lists in lists; deeper ones may contain themselves."""

_MAX_INTEGER = 2**63


class PythonClass:
    """An object of a class in a file, which is called with `Measurements` and returns `Commands`.

    It may have ``finish()``, called at the end of the run, and ``save()`` with ``restore(data)``,
    which return and take its state: numbers, text, None, and lists and dictionaries of them.

    Args:
        path: The file.
        name: Name of the class, which is made without arguments.

    Raises:
        InputError: if there is no such file or class, or it fails.
    """

    def __init__(self, path: Path, name: str) -> None:
        self._who = f"controller {name!r} of '{path}'"
        self._path, self._folder = path, os.open(".", os.O_RDONLY | os.O_CLOEXEC)
        if not path.is_file():
            raise InputError(f"there is no file '{path}' with the {self._who}")
        spec = importlib.util.spec_from_file_location("controller_of_a_case", path)
        if spec is None or spec.loader is None:
            raise InputError(f"'{path}' is no Python file: its name must end with .py")
        module, loader = importlib.util.module_from_spec(spec), spec.loader
        self._guard(f"'{path}' cannot be run", lambda: loader.exec_module(module))
        kind = vars(module).get(name)
        if not isinstance(kind, type):
            raise InputError(f"'{path}' has no class {name!r}")
        self._controller: Any = self._guard(f"the {self._who} cannot be made", kind)
        if not callable(self._controller):
            raise InputError(f"the {self._who} cannot be called: it has no method __call__")
        methods = [m for m in ("save", "restore") if callable(getattr(kind, m, None))]
        self._saves = len(methods) == 2
        if len(methods) == 1:
            raise InputError(f"the {self._who} has {methods[0]}, but save and restore need both")

    def respond(self, measured: Measurements) -> Commands:
        """Its return value.

        Raises:
            ForeignError: if it fails, or returns no commands.
        """
        time = measured.time
        return self._guard(
            f"the {self._who} failed at t = {time:g} s",
            lambda: check_commands(self._controller(measured), f"the {self._who}", time),
        )

    def save(self) -> RestartData:
        """Return value of its ``save``; empty without one."""
        if not self._saves:
            return RestartData()
        what = f"save() of the {self._who} failed"
        state = self._guard(what, lambda: copy_plain(self._controller.save()))
        return RestartData({"returned": state})

    def restore(self, data: RestartData) -> None:
        """Give its ``restore`` what ``save`` has returned."""
        what = f"restore() of the {self._who} failed"
        state = copy_plain(data.numbers["returned"])  # which it may change
        self._guard(what, lambda: self._controller.restore(state))

    def finish(self) -> None:
        """Call its ``finish``, if it has one."""
        what = f"finish() of the {self._who} failed, the results are complete"
        if callable(getattr(type(self._controller), "finish", None)):
            self._guard(what, lambda: self._controller.finish())

    def _guard(self, what: str, function: Callable[[], T]) -> T:
        """Call foreign code; whatever it raises becomes a ForeignError.

        Ctrl-C stays what it is, unless signals are caught elsewhere, so that the code itself has
        raised it. The folder in which the program works stays what it is, too.
        """
        try:
            with end_if_stuck():
                return function()
        except ForeignError:
            raise
        except BaseException as error:
            typed = signal.getsignal(signal.SIGINT) is signal.default_int_handler
            if isinstance(error, KeyboardInterrupt) and typed:
                raise
            raise ForeignError(f"{what}: {self._describe(error)}") from error
        finally:
            with suppress(OSError):  # somebody has removed it
                os.chdir(self._folder)

    def _describe(self, error: BaseException) -> str:
        """Kind and text of an error on one line, and its line in the file."""
        lines = [
            frame.lineno
            for frame in traceback.extract_tb(error.__traceback__)
            if Path(frame.filename) == self._path
        ]
        where = f" (line {lines[-1]})" if lines else ""
        return f"{describe_error(error)}{where}"


def copy_plain(value: Any, where: str = "", depth: int = 0) -> Any:
    """A copy of numbers, text, None, lists and dictionaries; tuples become lists.

    Args:
        where: What they are called in the message, as in ``["gains"][0]``.
    """
    if depth > DEPTH:
        raise TypeError(f"{where} is deeper than {DEPTH} lists, or contains itself")
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        if not -_MAX_INTEGER <= value < _MAX_INTEGER:
            raise TypeError(f"{where} is an integer beyond 64 bits")
        return int(value)
    if isinstance(value, float):
        return float(value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, (list, tuple)):
        return [copy_plain(v, f"{where}[{k}]", depth + 1) for k, v in enumerate(value)]
    if isinstance(value, dict):
        if wrong := [type(key).__name__ for key in value if not isinstance(key, str)]:
            raise TypeError(f"{where} has a key of type {wrong[0]}, expected text")
        return {str(k): copy_plain(v, f"{where}[{k!r}]", depth + 1) for k, v in value.items()}
    hint = ", use .tolist()" if hasattr(value, "tolist") else ""
    raise TypeError(
        f"{where or 'the result'} is of type {type(value).__name__}{hint}; expected numbers, "
        "text, None, lists or dictionaries"
    )
