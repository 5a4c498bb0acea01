"""The factor of a symmetric matrix that suits its ranks and its definiteness."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import DefiniteFactor, FreeSolver, SparseFactor


class SymmetricFactor(FreeSolver):
    """Factor of a symmetric matrix that is nearly always positive definite.

    CHOLMOD's L L^T, whose triangular solves are a quarter faster than those of MUMPS for large and
    three times faster for small matrices. MUMPS' L D L^T on several ranks, and from the first
    matrix on that turns out not to be positive definite (a strongly compressed body and a large
    step).

    Args:
        matrix: The matrix.
        prefix: Options prefix.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str) -> None:
        """Choose the package."""
        self._matrix, self._prefix = matrix, prefix
        alone = matrix.getComm().getSize() == 1
        self._factor: SparseFactor
        if alone and has_cholmod():
            self._factor = DefiniteFactor(matrix, prefix)
        else:
            self._factor = self._factorise_indefinite()
        self.iterations = 0

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        try:
            self._factor.update()
        except np.linalg.LinAlgError:  # on all ranks
            self._factor.destroy()
            self._factor = self._factorise_indefinite()
            self._factor.update()

    def count_negative(self) -> int:
        """Number of negative eigenvalues. Collective."""
        return self._factor.count_negative()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._factor.solve(b, x)
        self.iterations += 1

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, this rank's rows, shape (n, k)."""
        self.iterations += B.shape[1]
        return self._factor.solve_many(B)

    def destroy(self) -> None:
        """Free the factor. Collective."""
        self._factor.destroy()

    def _factorise_indefinite(self) -> SparseFactor:
        """The factor of any symmetric matrix."""
        self._matrix.setOption(PETSc.Mat.Option.SPD, False)
        return SparseFactor(self._matrix, self._prefix, symmetric=True)


def has_cholmod() -> bool:
    """Whether this PETSc has CHOLMOD."""
    return bool(PETSc.Sys.hasExternalPackage("suitesparse"))
