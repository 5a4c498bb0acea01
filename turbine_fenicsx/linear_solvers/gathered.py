"""A factor of a small matrix of all ranks that each of them has."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor


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
