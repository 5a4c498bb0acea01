"""Solvers for the free nodes of one flexible body, and the plainest: a sparse factor by PETSc."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx.foundation.types import Array

EXTRA_WORKSPACE = 60
"""Per cent by which MUMPS may exceed its estimate of the work space where pivots are delayed."""

LARGEST_WORKSPACE = 100 * EXTRA_WORKSPACE
"""Beyond this the matrix has no factor. Pivots are delayed by any number in small saddle points."""

WORKSPACE_TOO_SMALL = (-8, -9, -14, -15, -17, -20)
"""Error codes of MUMPS, the same on all ranks, that more work space mends."""

MAX_KEPT_COLUMNS = 16
"""Maximum number of columns of dense matrices that are kept for the next solve: those of a step,
not of a set-up."""


class FreeSolver(Protocol):
    """Solves with A_II. All methods are collective.

    Attributes:
        iterations: Krylov iterations so far; a direct solve counts as one.
        factors: Number of factors, and of the components of the matrix that they serve.
    """

    iterations: int
    factors: tuple[int, int] = (1, 1)
    _matrix: PETSc.Mat

    def update(self) -> None:
        """Prepare for the present values of the matrix.

        A solver that needs it no more may destroy it; it is then rebuilt before the next update.
        """

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, this rank's rows, shape (n, k)."""
        x, b = self._matrix.createVecs()
        X = np.empty_like(B)
        for k in range(B.shape[1]):
            b.array[:] = B[:, k]
            self.solve(b, x)
            X[:, k] = x.array_r
        x.destroy()
        b.destroy()
        return X

    def destroy(self) -> None:
        """Free everything."""


class SparseFactor(FreeSolver):
    """LU or Cholesky (L D L^T) factors of a distributed matrix that keeps its sparsity, by MUMPS.

    Args:
        symmetric: Whether the matrix is symmetric, which halves work and memory.
    """

    def __init__(
        self, matrix: PETSc.Mat, prefix: str, symmetric: bool = False, package: str = "mumps"
    ) -> None:
        """Create the solver; nothing is factorised yet."""
        self._matrix, self._prefix = matrix, prefix
        self._type = "cholesky" if symmetric else "lu"
        self.iterations = 0
        self._dense: dict[int, list[PETSc.Mat]] = {}  # by number of columns
        self._create(package)

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        self._ksp.setOperators(self._matrix)  # or setUp would leave it to the next solve
        self._ksp.setUp()
        while self._mumps_error() in WORKSPACE_TOO_SMALL and self._extra < LARGEST_WORKSPACE:
            self._extra *= 2
            self._ksp.reset()  # PETSc keeps the error, and would never factorise again
            self._ksp.setOperators(self._matrix)
            self._reserve()
            self._ksp.setUp()

    def count_negative(self) -> int:
        """Number of negative eigenvalues of a symmetric matrix, by MUMPS: of negative pivots."""
        return int(self._ksp.getPC().getFactorMatrix().getMumpsInfog(12))

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._ksp.solve(b, x)
        self.iterations += 1

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, this rank's rows, shape (n, k)."""
        pc, k = self._ksp.getPC(), B.shape[1]
        direct = self._ksp.getType() == "preonly" and pc.getType() in ("lu", "cholesky")
        if self._matrix.getComm().getSize() > 1 or not direct or self._mumps_error():
            # also with other solvers by the user's options; infinite where there is no factor
            return super().solve_many(B)
        if k not in self._dense:
            self._dense[k] = [PETSc.Mat().createDense(B.shape, comm=PETSc.COMM_SELF) for _ in "bx"]
            for matrix in self._dense[k]:
                matrix.setUp()
                matrix.assemble()
        b, x = self._dense[k]
        b.getDenseArray()[:] = B
        pc.getFactorMatrix().matSolve(b, x)
        self.iterations += k
        X: Array = x.getDenseArray().copy(order="F")
        if k > MAX_KEPT_COLUMNS:
            self._free_dense()
        return X

    def destroy(self) -> None:
        """Free the factor. Collective."""
        self._free_dense()
        self._ksp.destroy()

    def _create(self, package: str) -> None:
        """Create the solver of a package."""
        self._ksp = PETSc.KSP().create(self._matrix.getComm())
        self._ksp.setOptionsPrefix(self._prefix)
        self._ksp.setType("preonly")
        self._ksp.setOperators(self._matrix)
        pc = self._ksp.getPC()
        pc.setType(self._type)
        pc.setFactorSolverType(package)
        self._ksp.setFromOptions()
        self._extra = EXTRA_WORKSPACE
        self._is_mumps = pc.getFactorSolverType() == "mumps"
        self._reserve()

    def _free_dense(self) -> None:
        """Free the dense matrices of `solve_many`."""
        for pair in self._dense.values():
            for matrix in pair:
                matrix.destroy()
        self._dense.clear()

    def _reserve(self) -> None:
        """Set how much MUMPS may exceed its estimate of the work space."""
        if self._is_mumps:
            pc = self._ksp.getPC()
            pc.setFactorSetUpSolverType()
            pc.getFactorMatrix().setMumpsIcntl(14, self._extra)

    def _mumps_error(self) -> int:
        """Why MUMPS has no factor, zero if it has one."""
        if not self._is_mumps:
            return 0
        return min(0, int(self._ksp.getPC().getFactorMatrix().getMumpsInfog(1)))


def from_petsc(matrix: PETSc.Mat) -> csr_matrix:
    """Copy of a matrix of this rank alone."""
    return csr_matrix(matrix.getValuesCSR()[::-1], matrix.getSize())


def to_petsc(A: csr_matrix) -> PETSc.Mat:
    """Copy of a matrix, on this rank alone."""
    csr = A.indptr.astype(PETSc.IntType), A.indices.astype(PETSc.IntType), A.data
    return PETSc.Mat().createAIJ(A.shape, csr=csr, comm=PETSc.COMM_SELF)
