"""Factors of symmetric matrices: one shared by the ranks, and one that each of them has."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

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


class GatheredFactor:
    """Solves with a small symmetric matrix, all of it on each rank; a context for PCPYTHON.

    Each rank gets the right-hand side of all of them in one collective operation and solves for
    itself, where a factor shared by the ranks takes a hundred. PETSc's PCREDUNDANT does the same
    with a message to each other rank. The factor has the options prefix of the preconditioner.
    """

    def __init__(self) -> None:
        """Nothing is factorised yet."""
        self._made: list[PETSc.Object] = []

    def setUp(self, pc: PETSc.PC) -> None:
        """Gather and factorise. Collective."""
        self._free()
        _, matrix = pc.getOperators()
        rows = PETSc.IS().createStride(matrix.getSize()[0], step=1, comm=PETSc.COMM_SELF)
        (gathered,) = matrix.createSubMatrices([rows], [rows])
        rows.destroy()
        self._factor = SymmetricFactor(gathered, pc.getOptionsPrefix())
        self._factor.update()
        self._x, self._b = gathered.createVecs()
        self._made = [self._factor, gathered, self._x, self._b]
        self._rows = slice(*matrix.getOwnershipRange())
        self._comm = matrix.getComm().tompi4py()
        self._counts = self._comm.allgather(matrix.getLocalSize()[0])

    def apply(self, pc: PETSc.PC, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._comm.Allgatherv(np.array(b.array_r), [self._b.array, self._counts, MPI.DOUBLE])
        self._factor.solve(self._b, self._x)
        x.array[:] = self._x.array_r[self._rows]

    def destroy(self, pc: PETSc.PC) -> None:
        """Free everything."""
        self._free()

    def _free(self) -> None:
        """Free the factor and what belongs to it."""
        for thing in self._made:
            thing.destroy()
        self._made = []


def has_cholmod() -> bool:
    """Whether this PETSc has CHOLMOD."""
    return bool(PETSc.Sys.hasExternalPackage("suitesparse"))
