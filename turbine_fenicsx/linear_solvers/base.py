"""Interface of linear solvers for the Newton iteration."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

from turbine_fenicsx.foundation.restart_data import RestartData


class LinearSolver(Protocol):
    """Solves, exactly or nearly, with the nested tangent of a step.

    It is applied as the preconditioner of SNES' Krylov method, which by default takes it as exact
    (``preonly``). All methods are collective.
    """

    @property
    def krylov_iterations(self) -> int:
        """Krylov iterations since the start; a direct solve counts as one."""

    def start_iteration(self) -> None:
        """A new Newton iteration begins: the step holds the state at t_n and the first guess."""

    def update(self, x: PETSc.Vec) -> None:
        """Prepare for the tangent at the unknowns X."""

    def turn(self, x: PETSc.Vec) -> bool:
        """Take the last tangent to the unknowns X instead of a new one; whether that can be."""

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""

    def end_iteration(self, converged: bool) -> bool:
        """The Newton iteration has ended; whether to try again, with a tangent less old."""

    def save(self) -> RestartData:
        """State that later solves depend on, apart from the step; a new solver can `restore` it."""

    def restore(self, data: RestartData) -> None:
        """Restore the state of the solver that saved this; nothing was solved yet."""

    def destroy(self) -> None:
        """Free all PETSc objects."""


class DirectSolver:
    """Base of linear solvers that refactorise in each update.

    Attributes:
        krylov_iterations: Solves so far.
    """

    krylov_iterations = 0

    def start_iteration(self) -> None:
        """There is nothing to prepare."""

    def turn(self, x: PETSc.Vec) -> bool:
        """Each tangent is new."""
        return False

    def end_iteration(self, converged: bool) -> bool:
        """There is nothing to learn from the iteration."""
        return False

    def save(self) -> RestartData:
        """Empty data: nothing is kept between steps."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """There is nothing to restore."""
