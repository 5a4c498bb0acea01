"""A controller that is a class in a Python file of the user.

The file is run as it is, with all rights of the user: naming it in a case is a decision to run it.
"""

from __future__ import annotations

import importlib.util
import traceback
from pathlib import Path
from typing import Any

from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.foundation.errors import InputError


class PythonClass:
    """An object of a class in a file, which is called with `Measurements` and returns `Commands`.

    Args:
        path: The file.
        name: Name of the class, which is made without arguments.

    Raises:
        InputError: if there is no such file or class, or it fails.
    """

    def __init__(self, path: Path, name: str) -> None:
        self._who = f"controller {name!r} of '{path}'"
        self._path = path
        if not path.is_file():
            raise InputError(f"there is no file '{path}' with the {self._who}")
        spec = importlib.util.spec_from_file_location("controller_of_a_case", path)
        if spec is None or spec.loader is None:
            raise InputError(f"'{path}' is no Python file: its name must end with .py")
        module = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            raise InputError(f"'{path}' cannot be run: {self._describe(error)}") from error
        kind = getattr(module, name, None)
        if not isinstance(kind, type):
            raise InputError(f"'{path}' has no class {name!r}")
        try:
            self._controller: Any = kind()
        except Exception as error:
            raise InputError(f"the {self._who} cannot be made: {self._describe(error)}") from error
        if not callable(self._controller):
            raise InputError(f"the {self._who} cannot be called: it has no method __call__")

    def respond(self, measured: Measurements) -> Commands:
        """What it returns, unchecked."""
        try:
            found: Commands = self._controller(measured)
        except Exception as error:
            raise InputError(
                f"the {self._who} failed at t = {measured.time:g} s: {self._describe(error)}"
            ) from error
        return found

    def finish(self) -> None:
        """Call its ``finish``, if it has one."""
        finish = getattr(self._controller, "finish", None)
        if callable(finish):
            finish()

    def _describe(self, error: Exception) -> str:
        """Kind and text of an error, and its line in the file."""
        lines = [
            frame.lineno
            for frame in traceback.extract_tb(error.__traceback__)
            if Path(frame.filename) == self._path
        ]
        where = f" (line {lines[-1]})" if lines else ""
        return f"{type(error).__name__}: {error}{where}"
