"""Solvers for the free nodes of one flexible body: sparse factors through PETSc."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

EXTRA_WORKSPACE = 60
"""Per cent by which MUMPS may exceed its estimate of the work space where pivots are delayed."""

TRUSTED = 1e-6
"""A factor is trusted if it solves for a known vector with this relative error."""


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
    """LU or Cholesky (L D L^T) factors of a distributed matrix that keeps its sparsity, by MUMPS.

    Args:
        matrix: The matrix.
        prefix: Options prefix.
        symmetric: Whether the matrix is symmetric, which halves work and memory.
        package: Package of PETSc that factorises.
    """

    def __init__(
        self, matrix: PETSc.Mat, prefix: str, symmetric: bool = False, package: str = "mumps"
    ) -> None:
        """Create the solver; nothing is factorised yet."""
        self._ksp = PETSc.KSP().create(matrix.getComm())
        self._ksp.setOptionsPrefix(prefix)
        self._ksp.setType("preonly")
        self._ksp.setOperators(matrix)
        pc = self._ksp.getPC()
        pc.setType("cholesky" if symmetric else "lu")
        pc.setFactorSolverType(package)
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


class SymmetricFactor:
    """Factor of a symmetric matrix that is nearly always positive definite.

    On one rank CHOLMOD's L L^T, whose triangular solves are a quarter faster than those of MUMPS
    for large and three times faster for small matrices. MUMPS' L D L^T on several ranks, where
    PETSc has no CHOLMOD, and from the first matrix on that turns out not to be positive definite
    (a strongly compressed body and a large step).

    Args:
        matrix: The matrix.
        prefix: Options prefix.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str) -> None:
        """Choose the package."""
        self._matrix, self._prefix = matrix, prefix
        self._positive_definite = matrix.getComm().getSize() == 1 and bool(
            PETSc.Sys.hasExternalPackage("suitesparse")
        )
        self._factor = self._make()
        self.iterations = 0

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        if self._positive_definite and not self._factorised():
            self._positive_definite = False
            self._factor.destroy()
            self._factor = self._make()
        if not self._positive_definite:
            self._factor.update()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._factor.solve(b, x)
        self.iterations += 1

    def destroy(self) -> None:
        """Free the factor. Collective."""
        self._factor.destroy()

    def _make(self) -> SparseFactor:
        """A factor by the package that suits the matrix."""
        self._matrix.setOption(PETSc.Mat.Option.SPD, self._positive_definite)
        package = "cholmod" if self._positive_definite else "mumps"
        return SparseFactor(self._matrix, self._prefix, symmetric=True, package=package)

    def _factorised(self) -> bool:
        """Factorise and solve for a known vector: CHOLMOD reports no lost definiteness itself."""
        x, b = self._matrix.createVecs()
        x.set(1.0)
        self._matrix.mult(x, b)
        try:
            self._factor.update()
            self._factor.solve(b, x)
            x.shift(-1.0)
            return bool(x.norm(PETSc.NormType.INFINITY) < TRUSTED)
        except PETSc.Error:
            return False
        finally:
            x.destroy()
            b.destroy()
