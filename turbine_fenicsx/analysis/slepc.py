"""SLEPc, which comes beside DOLFINx but is not part of it, and what its iterations share."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from petsc4py import PETSc

from turbine_fenicsx.analysis.bordered_solver import BorderedSolver
from turbine_fenicsx.foundation.errors import InputError


def import_slepc() -> Any:
    """The module `slepc4py.SLEPc`."""
    try:
        from slepc4py import SLEPc
    except ImportError as error:
        raise InputError(
            f"modes need slepc4py, which {sys.executable} does not have ({error}): on Debian `apt "
            "install python3-slepc4py-real` brings it, with conda `conda install -c conda-forge "
            "slepc4py`, and dolfinx-solver-real from PyPI contains it"
        ) from None
    return SLEPc


@dataclass(frozen=True, eq=False)
class Pair:
    """An eigenvalue and its vector, of unit modal mass.

    Args:
        eigenvalue: s [rad/s], with a positive or no imaginary part; or w^2 [rad^2/s^2].
        parts: Real and imaginary part of the vector, flat ones; the real one alone if it is real.
        is_rigid: Whether the vector has no stiffness but round-off.
        round_off: Error of the square of its frequency by the last digits of K [rad^2/s^2].
    """

    eigenvalue: complex
    parts: tuple[PETSc.Vec, ...]
    is_rigid: bool = False
    round_off: float = 0.0

    def destroy(self) -> None:
        """Free the vectors. Collective."""
        for part in self.parts:
            part.destroy()


class _Inverse:
    """The bordered solver as a preconditioner of PETSc."""

    def __init__(self, solver: BorderedSolver) -> None:
        self._solver = solver

    def apply(self, _: PETSc.PC, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        self._solver.solve(b, x)


def invert_by(iteration: Any, solver: BorderedSolver) -> Any:
    """The transform of an iteration, which then inverts its operator by the bordered solver."""
    transform = iteration.getST()
    transform.setType(transform.Type.SINVERT)
    transform.setMatMode(transform.MatMode.SHELL)
    ksp = transform.getKSP()
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.PYTHON)
    ksp.getPC().setPythonContext(_Inverse(solver))
    return transform


@contextmanager
def keep_if_interrupted(solver: Any) -> Iterator[None]:
    """Never free a solver that an exception has left in the midst of its iteration.

    SLEPc cannot free what it has lent out then: it fails, or crashes when the program ends. Newer
    releases wrap Ctrl-C in other errors.
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
