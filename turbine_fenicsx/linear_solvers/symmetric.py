"""The factor of a symmetric matrix that suits its ranks and its definiteness."""

from __future__ import annotations

from petsc4py import PETSc

from turbine_fenicsx.foundation.petsc_options import default_options
from turbine_fenicsx.linear_solvers.factor import SparseFactor

ROOT_OF_DIAGONAL = {"mat_cholmod_final_asis": "0", "mat_cholmod_final_ll": "1"}
"""L L^T of small matrices, too: CHOLMOD has L D L^T for them, and takes any signs in D."""

SILENT = {"mat_cholmod_print": "0"}
"""No warning of what another factor takes over."""


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
        alone = matrix.getComm().getSize() == 1
        super().__init__(matrix, prefix, True, "cholmod" if alone and has_cholmod() else "mumps")

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective."""
        try:
            with default_options(self._prefix, ROOT_OF_DIAGONAL | SILENT):
                super().update()
        except PETSc.Error:
            if not self._is_definite:
                raise
            self.destroy()
            self._create("mumps")
            super().update()

    def count_negative(self) -> int:
        """Number of negative eigenvalues. Collective."""
        return 0 if self._is_definite else super().count_negative()

    @property
    def _is_definite(self) -> bool:
        """Whether the factor is that of a positive definite matrix."""
        return bool(self._ksp.getPC().getFactorSolverType() == "cholmod")


def has_cholmod() -> bool:
    """Whether this PETSc has CHOLMOD."""
    return bool(PETSc.Sys.hasExternalPackage("suitesparse"))
