"""The factor of a symmetric matrix that suits its ranks and its definiteness."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.linear.factor import FreeSolver, SparseFactor
from turbine_fenicsx.linear.substructures import Substructures, interface_rows, worthwhile

TRUSTED = 1e-4
"""A factor is trusted if it solves for a known vector with this relative error."""


class SymmetricFactor:
    """Factor of a symmetric matrix that is nearly always positive definite.

    CHOLMOD's L L^T, whose triangular solves are a quarter faster than those of MUMPS for large and
    three times faster for small matrices; on several ranks one for each, joined by
    `Substructures`, which halves the time of MUMPS on two. MUMPS' L D L^T where the ranks meet in
    too many unknowns, and from the first matrix on that turns out not to be positive definite
    (a strongly compressed body and a large step).

    Args:
        matrix: The matrix.
        prefix: Options prefix.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str) -> None:
        """Choose the package."""
        self._matrix, self._prefix = matrix, prefix
        self._positive_definite = bool(PETSc.Sys.hasExternalPackage("suitesparse"))
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

    def _make(self) -> FreeSolver:
        """A factor by the package that suits the matrix."""
        matrix, prefix = self._matrix, self._prefix
        if self._positive_definite and matrix.getComm().getSize() > 1:
            interface = interface_rows(matrix)
            if worthwhile(matrix, interface):
                return Substructures(matrix, interface, prefix)
            self._positive_definite = False
        matrix.setOption(PETSc.Mat.Option.SPD, self._positive_definite)
        package = "cholmod" if self._positive_definite else "mumps"
        return SparseFactor(matrix, prefix, symmetric=True, package=package)

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
        except (PETSc.Error, np.linalg.LinAlgError):
            return False
        finally:
            x.destroy()
            b.destroy()
