"""The factor of a symmetric matrix that suits its ranks and its definiteness."""

from __future__ import annotations

from petsc4py import PETSc

from turbine_fenicsx.foundation.petsc_options import default_options
from turbine_fenicsx.linear_solvers.factor import SparseFactor

TRUSTED = 1e-4
"""A factor is trusted if it solves for a known vector with this relative error."""


class SymmetricFactor(SparseFactor):
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
        self._is_definite = matrix.getComm().getSize() == 1 and has_cholmod()
        matrix.setOption(PETSc.Mat.Option.SPD, self._is_definite)
        super().__init__(matrix, prefix, True, "cholmod" if self._is_definite else "mumps")

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        if self._is_definite and not self._factorise_definite():
            self._is_definite = False
            self._matrix.setOption(PETSc.Mat.Option.SPD, False)
            self.destroy()
            self._create("mumps")
        if not self._is_definite:
            super().update()

    def count_negative(self) -> int:
        """Number of negative eigenvalues. Collective."""
        return 0 if self._is_definite else super().count_negative()

    def _factorise_definite(self) -> bool:
        """Whether L L^T exists: CHOLMOD does not say so, but then it does not solve."""
        x, b = self._matrix.createVecs()
        x.set(1.0)
        self._matrix.mult(x, b)
        try:
            with default_options(self._prefix, {"mat_cholmod_print": "0"}):
                super().update()  # and no warning: there is another factor for such a matrix
            self._ksp.solve(b, x)
            x.shift(-1.0)
            return bool(x.norm(PETSc.NormType.INFINITY) < TRUSTED)
        except PETSc.Error:
            return False
        finally:
            x.destroy()
            b.destroy()


def has_cholmod() -> bool:
    """Whether this PETSc has CHOLMOD."""
    return bool(PETSc.Sys.hasExternalPackage("suitesparse"))
