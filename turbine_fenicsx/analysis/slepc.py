"""SLEPc, which comes beside DOLFINx but is not part of it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from turbine_fenicsx.foundation.errors import InputError


def import_slepc() -> Any:
    """The module `slepc4py.SLEPc`.

    Raises:
        InputError: if it is not installed, with what brings it.
    """
    try:
        from slepc4py import SLEPc
    except ImportError as error:
        raise InputError(
            f"modes need slepc4py, which {sys.executable} does not have ({error}): on Debian `apt "
            "install python3-slepc4py-real` brings it, with conda `conda install -c conda-forge "
            "slepc4py`, and dolfinx-solver-real from PyPI contains it"
        ) from None
    return SLEPc


@contextmanager
def keep_if_interrupted(solver: Any) -> Iterator[None]:
    """Never free a solver that an exception has left in the midst of its iteration.

    SLEPc cannot free what it has lent out then: it fails, or crashes when the program ends. Newer
    releases wrap Ctrl-C in errors of their own.
    """
    try:
        yield
    except BaseException as error:
        solver.incRef()
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, KeyboardInterrupt):
                raise cause from None
            cause = cause.__cause__ or cause.__context__
        raise
