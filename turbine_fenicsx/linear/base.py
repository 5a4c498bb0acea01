"""What every linear solver is to Newton's method."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc


class LinearSolver(Protocol):
    """Solves, exactly or not, with the nested tangent of an `EnergyMomentumStep`.

    It is applied as the preconditioner of SNES' Krylov method, which by default takes it as exact
    (``preonly``). A frozen factor is one more class of this kind.
    """

    def update(self) -> None:
        """Prepare for the tangent that the step has just assembled. Collective."""

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side. Collective."""

    def destroy(self) -> None:
        """Free all PETSc objects. Collective."""
