"""A sparse factor on each rank, joined at the few unknowns where ranks meet.

S holds the unknowns of each rank that the matrix couples to a higher rank, i the others of a rank.
Without S the ranks are independent, so that with W_i = A_ii^{-1} A_iS

    (A_SS - sum_i A_Si W_i) x_S = b_S - sum_i A_Si A_ii^{-1} b_i,
                            x_i = A_ii^{-1} b_i - W_i x_S:

each rank solves once with its own factor, and S, a few cross-sections of a slender body, is solved
for by all of them, each for itself: its matrix is sparse too, as a section only meets the next.

W_i has a column for each unknown of S. By Saint-Venant's principle they look alike far from S:
motions of whole cross-sections. With a slab s of rows next to S and the rows o beyond it

    W_i = (W_s, 0) - A_ii^{-1} (0, A_os W_s),      W_s = A_ss^{-1} A_sS.

The forces A_os W_s that S exerts beyond the slab therefore have a low rank, and only so many
solutions with the large factor are needed.
"""

from __future__ import annotations

from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, vstack

from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import DefiniteFactor, FreeSolver, copy_csr

Indices = npt.NDArray[np.int32]

SLAB = 16
"""Rows of the slab for each column of W_i: so many layers of a slender body."""

NEGLIGIBLE = 1e-6
"""Singular values of the forces beyond the slab below this part of the largest are left out."""

WIDEST = 90
"""Largest square of the number of columns of W_i for each row of a rank."""

LONGEST = 2
"""Unknowns of S for each row of a rank, up to which solving for S takes no longer than the rest."""


def find_interface_rows(matrix: PETSc.Mat) -> Indices:
    """Rows of this rank, counted from its first, that are coupled to a higher rank."""
    first, last = matrix.getOwnershipRange()
    indptr, columns, _ = matrix.getValuesCSR()
    rows = np.repeat(np.arange(last - first, dtype=np.int32), np.diff(indptr))
    interface: npt.NDArray[np.int32] = np.unique(rows[columns >= last])
    return interface


def is_worthwhile(matrix: PETSc.Mat, interface: Indices) -> bool:
    """Whether S is small, for each rank and in all: slender bodies, not too many ranks.

    Args:
        matrix: The matrix.
        interface: `find_interface_rows` of the matrix.
    """
    comm, (first, last) = matrix.getComm().tompi4py(), matrix.getOwnershipRange()
    columns = matrix.getValuesCSR()[1]
    others = last - first - interface.size
    met = interface.size + np.unique(columns[columns < first]).size
    fits = bool(others > 0 and met**2 <= WIDEST * (last - first))
    size = comm.allreduce(interface.size)
    return bool(comm.allreduce(fits, op=MPI.LAND)) and (
        size * comm.size <= LONGEST * matrix.getSize()[0]
    )


class Substructures(FreeSolver):
    """Solves with a distributed symmetric positive definite matrix that keeps its sparsity.

    Solutions have a relative error of about `NEGLIGIBLE`.

    Args:
        matrix: The matrix.
        interface: `find_interface_rows` of the matrix.
        prefix: Options prefix of the factors.
    """

    def __init__(self, matrix: PETSc.Mat, interface: Indices, prefix: str) -> None:
        """Take the matrix apart; nothing is factorised yet."""
        self._matrix, self._comm = matrix, matrix.getComm().tompi4py()
        first, last = matrix.getOwnershipRange()
        own = first + interface
        everyone = self._comm.allgather(own)
        start = sum(rows.size for rows in everyone[: self._comm.rank])
        self._mine = slice(start, start + own.size)
        self._S, self._i = interface, np.setdiff1d(np.arange(last - first), interface)
        S_mine, i, S = map(_make_index_set, (own, first + self._i, np.concatenate(everyone)))
        self._sets = [i, i, S_mine], [i, S, S]
        self._parts = matrix.createSubMatrices(*self._sets)
        self._prefix = prefix
        self._factor = DefiniteFactor(self._parts[0], prefix)
        self._b, self._x = self._parts[0].createVecs()
        self._common: tuple[Any, ...] = ()  # the matrix of S and its factor, if there is any S
        self._b_S, self._x_S = (PETSc.Vec().createSeq(S.getSize()) for _ in range(2))
        self.iterations = 0

    def update(self) -> None:
        """Factorise the present values of the matrix. Collective.

        Raises:
            LinAlgError: on all ranks, if the matrix is not positive definite.
        """
        self._parts = self._matrix.createSubMatrices(*self._sets, submats=self._parts)
        own: tuple[csr_matrix, Array] | None = None
        try:
            own = self._eliminate()
            definite = bool(np.all(np.isfinite(own[1])))
        except (PETSc.Error, np.linalg.LinAlgError):
            definite = False
        self._require(definite)
        definite = True
        try:
            self._factorise_common(self._comm.allgather((own, self._columns)))
        except np.linalg.LinAlgError:
            definite = False
        self._require(definite)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        self._b.array[:] = b.array_r[self._i]
        self._factor.solve(self._b, self._x)
        x_i = self._x.array
        b_S = np.zeros(self._b_S.size)
        b_S[self._mine] = b.array_r[self._S]
        b_S[self._columns] -= self._A_Se @ x_i[self._edge]
        self._b_S.array[:] = sum_over_ranks(self._comm, b_S)
        if self._common:
            self._common[1].solve(self._b_S, self._x_S)
        x_S = self._x_S.array_r
        near = x_S[self._columns]
        x_i[self._slab] -= self._W_single @ near.astype(np.float32)
        x_i -= self._far @ (self._modes @ near)
        x.array[self._i], x.array[self._S] = x_i, x_S[self._mine]
        self.iterations += 1

    def destroy(self) -> None:
        """Free everything."""
        self._factor.destroy()
        sets, vectors = (*self._sets[0], *self._sets[1]), (self._b, self._x, self._b_S, self._x_S)
        for thing in (*self._common, *self._parts, *vectors, *sets):
            thing.destroy()

    def _require(self, definite: bool) -> None:
        """Raise a LinAlgError on all ranks if it is not so on one."""
        if not self._comm.allreduce(definite, op=MPI.LAND):
            raise np.linalg.LinAlgError("the matrix is not positive definite")

    def _factorise_common(self, parts: list[Any]) -> None:
        """Add up the matrix of S from the parts of all ranks, and factorise it."""
        rows = [own[0] for own, _ in parts]
        S = vstack(rows).tocoo()
        entries, i, j = [S.data], [S.row], [S.col]
        for (_, block), columns in parts:
            entries.append(-block.ravel())
            i.append(np.repeat(columns, columns.size))
            j.append(np.tile(columns, columns.size))
        indices = np.concatenate(i), np.concatenate(j)
        A = csr_matrix((np.concatenate(entries), indices), S.shape)
        for thing in self._common:
            thing.destroy()
        self._common = ()
        if A.nnz:
            csr = A.indptr, A.indices, A.data
            matrix = PETSc.Mat().createAIJ(A.shape, csr=csr, comm=PETSc.COMM_SELF)
            self._common = matrix, DefiniteFactor(matrix, self._prefix)
            self._common[1].update()

    def _eliminate(self) -> tuple[csr_matrix, Array]:
        """Factorise, find W_i, and return this rank's rows of A_SS, and its A_Si W_i."""
        A_ii, A_iS, A_SS = (copy_csr(part) for part in self._parts)
        self._factor.update()
        self._columns = np.unique(A_iS.indices)
        A_iS = A_iS[:, self._columns]
        self._edge = np.flatnonzero(np.diff(A_iS.indptr))
        self._A_Se = A_iS[self._edge].T.tocsr()
        self._slab = _collect_layers(A_ii, self._edge, SLAB * self._columns.size)
        W = self._respond(A_ii[self._slab][:, self._slab], A_iS[self._slab].toarray(order="F"))
        self._W_single = W.astype(np.float32)  # as accurate as the rest, and half the memory
        self._far, self._modes = self._respond_beyond(A_ii, W)
        W_e = W[np.searchsorted(self._slab, self._edge)] + self._far[self._edge] @ self._modes
        return A_SS, self._A_Se @ W_e

    def _respond(self, A_ss: csr_matrix, forces: Array) -> Array:
        """A_ss^{-1} times some forces; the matrix is factorised for this alone."""
        if not forces.size:
            return forces
        A = PETSc.Mat().createAIJ(
            A_ss.shape, csr=(A_ss.indptr, A_ss.indices, A_ss.data), comm=PETSc.COMM_SELF
        )
        factor = DefiniteFactor(A, self._prefix)
        factor.update()
        response = factor.solve_many(forces)
        factor.destroy()
        A.destroy()
        return response

    def _respond_beyond(self, A_ii: csr_matrix, W: Array) -> tuple[Array, Array]:
        """Factors of -A_ii^{-1} (0, A_os W_s), shapes (i, rank) and (rank, columns)."""
        o = np.setdiff1d(np.arange(self._i.size), self._slab)
        A_os = A_ii[self._slab][:, o].T.tocsr()
        loaded = np.flatnonzero(np.diff(A_os.indptr))
        U, s, V = np.linalg.svd(A_os[loaded] @ W, full_matrices=False)
        rank = int(np.sum(s > NEGLIGIBLE * np.max(s, initial=0.0)))
        forces = np.zeros((self._i.size, rank))
        forces[o[loaded]] = -U[:, :rank] * s[:rank]
        return self._factor.solve_many(forces) if rank else forces, V[:rank]


def _make_index_set(rows: Indices) -> PETSc.IS:
    """An index set of this rank alone."""
    return PETSc.IS().createGeneral(rows.astype(PETSc.IntType), comm=PETSc.COMM_SELF)


def _collect_layers(A: csr_matrix, rows: Indices, size: int) -> Indices:
    """Rows and their neighbours, layer by layer until there are ``size`` of them; sorted."""
    inside = np.zeros(A.shape[0], dtype=bool)
    inside[rows] = True
    while rows.size and np.count_nonzero(inside) < size:
        neighbours = np.unique(A[rows].indices)
        rows = neighbours[~inside[neighbours]]
        inside[rows] = True
    return np.flatnonzero(inside)
