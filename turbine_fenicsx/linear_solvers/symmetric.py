"""The factor of a symmetric matrix that suits its ranks and its definiteness."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import DefiniteFactor, FreeSolver, SparseFactor
from turbine_fenicsx.linear_solvers.substructures import (
    Substructures,
    find_interface_rows,
    is_worthwhile,
)


class SymmetricFactor(FreeSolver):
    """Factor of a symmetric matrix that is nearly always positive definite.

    CHOLMOD's L L^T, whose triangular solves are a quarter faster than those of MUMPS for large and
    three times faster for small matrices; on several ranks one for each, joined by
    `Substructures`, which halves the time of MUMPS on two. MUMPS' L D L^T where the ranks meet in
    too many unknowns, and from the first matrix on that turns out not to be positive definite
    (a strongly compressed body and a large step).

    Args:
        matrix: The matrix.
        prefix: Options prefix.
        exact: Whether solutions must be exact to round-off, which leaves out `Substructures`.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str, exact: bool = False) -> None:
        """Choose the package."""
        self._matrix, self._prefix, self._exact = matrix, prefix, exact
        definite = (
            self._factorise_definite() if PETSc.Sys.hasExternalPackage("suitesparse") else None
        )
        self._factor = definite or self._factorise_indefinite()
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
        return self._factor.count_negative() if isinstance(self._factor, SparseFactor) else 0

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._factor.solve(b, x)
        self.iterations += 1

    def solve_block(self, B: PETSc.Mat, X: PETSc.Mat) -> None:
        """Solve for the columns of a dense matrix on one rank, all at once."""
        assert isinstance(self._factor, SparseFactor)
        self._factor.solve_block(B, X)
        self.iterations += B.getSize()[1]

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, this rank's rows, shape (n, k)."""
        self.iterations += B.shape[1]
        return self._factor.solve_many(B)

    def destroy(self) -> None:
        """Free the factor. Collective."""
        self._factor.destroy()

    def _factorise_definite(self) -> FreeSolver | None:
        """The factor of a positive definite matrix; None if there is none that serves."""
        if self._matrix.getComm().getSize() == 1:
            return DefiniteFactor(self._matrix, self._prefix)
        if self._exact:
            return None
        interface = find_interface_rows(self._matrix)
        if not is_worthwhile(self._matrix, interface):
            return None
        return Substructures(self._matrix, interface, self._prefix)

    def _factorise_indefinite(self) -> FreeSolver:
        """The factor of any symmetric matrix."""
        self._matrix.setOption(PETSc.Mat.Option.SPD, False)
        return SparseFactor(self._matrix, self._prefix, symmetric=True)
