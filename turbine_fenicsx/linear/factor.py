"""Solvers for the free nodes of one flexible body: sparse factors through PETSc."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

EXTRA_WORKSPACE = 60
"""Per cent by which MUMPS may exceed its estimate of the work space where pivots are delayed."""


class FreeSolver(Protocol):
    """Solves with A_II. All methods are collective.

    Attributes:
        iterations: Krylov iterations so far; a direct solve counts as one.
    """

    iterations: int

    def update(self) -> None:
        """Prepare for the present values of the matrix."""

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""

    def destroy(self) -> None:
        """Free everything."""


class SparseFactor:
    """LU or Cholesky (L D L^T) factors of a distributed matrix that keeps its sparsity.

    Args:
        matrix: The matrix.
        prefix: Options prefix; the default is MUMPS.
        symmetric: Whether the matrix is symmetric, which halves work and memory.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str, symmetric: bool = False) -> None:
        """Create the solver; nothing is factorised yet."""
        self._ksp = PETSc.KSP().create(matrix.getComm())
        self._ksp.setOptionsPrefix(prefix)
        self._ksp.setType("preonly")
        self._ksp.setOperators(matrix)
        pc = self._ksp.getPC()
        pc.setType("cholesky" if symmetric else "lu")
        pc.setFactorSolverType("mumps")
        self._ksp.setFromOptions()
        if pc.getFactorSolverType() == "mumps":
            pc.setFactorSetUpSolverType()
            pc.getFactorMatrix().setMumpsIcntl(14, EXTRA_WORKSPACE)
        self.iterations = 0

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        self._ksp.setUp()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._ksp.solve(b, x)
        self.iterations += 1

    def destroy(self) -> None:
        """Free the factor. Collective."""
        self._ksp.destroy()
