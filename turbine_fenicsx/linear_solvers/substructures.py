"""A sparse factor on each rank, joined at the few unknowns where ranks meet.

S holds the unknowns that cells of several ranks share, i the others of a rank. Without S the ranks
are independent, so that with W_i = A_ii^{-1} A_iS

    (A_SS - sum_i A_Si W_i) x_S = b_S - sum_i A_Si A_ii^{-1} b_i,
                            x_i = A_ii^{-1} b_i - W_i x_S.

Each rank solves once with its own factor. All ranks solve for S, a few cross-sections of a slender
body, redundantly: its matrix is sparse too, as a section only meets the next. Congruent parts on a
rank, such as three blades or the same slab of each, share factor and W_i.
"""

from __future__ import annotations

from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, vstack

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.machine import trim_heap
from turbine_fenicsx.foundation.parallel import raise_together, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.congruence import find_groups, label_components
from turbine_fenicsx.linear_solvers.factor import FreeSolver, from_petsc, to_petsc
from turbine_fenicsx.linear_solvers.shared import (
    CongruentParts,
    Indices,
    Nodes,
    dofs_of,
    find_surroundings,
)
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel

Mask = npt.NDArray[np.bool_]

WIDEST = 90
"""Largest square of the number of unknowns around a part for each row of a rank, or sum of these
where parts are not of the same size."""

MAX_INTERFACE_RATIO = 2
"""Unknowns of S for each row of a rank, up to which solving for S takes no longer than the rest."""


class Substructures(FreeSolver):
    """Solves with a distributed symmetric matrix that keeps its sparsity.

    Where there is no factor, solutions are not finite.

    Args:
        matrix: The matrix, three rows for each node.
        positions: Initial positions of the nodes of this rank, shape (n, 3) [m].
        shared: Which of them are in S, shape (n,).

    Attributes:
        rotations: Rotations of the material since then, shape (3, 3, n); set before `update`.
    """

    def __init__(self, matrix: PETSc.Mat, positions: Array, shared: Mask, prefix: str) -> None:
        """Take the matrix apart; nothing is compared or factorised yet."""
        self._matrix, self._comm, self._prefix = matrix, matrix.getComm().tompi4py(), prefix
        self._positions, self._shared = positions, shared
        self.rotations: Array = np.repeat(np.eye(3)[:, :, None], len(positions), axis=2)
        self._i, self._S = dofs_of(np.flatnonzero(~shared)), dofs_of(np.flatnonzero(shared))
        own = self._comm.allgather(matrix.getOwnershipRange()[0] + self._S)
        start = sum(rows.size for rows in own[: self._comm.rank])
        self._mine, self._all_S = slice(start, start + self._S.size), np.concatenate(own)
        self._groups: list[CongruentParts] = []
        self._common: tuple[Any, ...] = ()  # the matrix of S and its factor, if there is any S
        self.iterations = 0

    def pays_off(self) -> bool:
        """Whether there are several on one rank; on more, whether S is small. Collective.

        For each rank and in all: slender bodies, not too many ranks.
        """
        if self._comm.size == 1:
            return bool(np.any(label_components(*self._matrix.getRowIJ())))
        A_ii, A_iS, _ = self._find_blocks()
        part, met = label_components(A_ii.indptr, A_ii.indices), A_iS.tocoo()
        pairs = np.unique(np.stack([part[met.row // 3], met.col]), axis=1)
        sizes = np.bincount(part)
        around = np.bincount(pairs[0], minlength=sizes.size)
        alike = np.unique(np.stack([sizes, around]), axis=1)[1].astype(float)
        rows = self._matrix.getSizes()[0]
        fits = sizes.size > 0 and bool(np.sum(alike**2) <= WIDEST * rows[0])
        small = self._all_S.size * self._comm.size <= MAX_INTERFACE_RATIO * rows[1]
        return bool(self._comm.allreduce(fits, op=MPI.LAND)) and small

    def update(self) -> None:
        """Find what is congruent, and factorise the present values of the matrix. Collective.

        The matrix is destroyed.
        """
        self.destroy()
        self._groups, A_SS = self._take_apart()
        self._matrix.destroy()
        trim_heap()
        blocks: list[tuple[Indices, Array]] | None = None
        error: Exception | None = None
        try:
            found = [zip(g.columns, g.factorise(), strict=True) for g in self._groups]
            blocks = [pair for pairs in found for pair in pairs]
        except np.linalg.LinAlgError:  # then there is none on any rank
            pass
        except Exception as raised:  # memory, say: all ranks must hear of it
            error = raised
        raise_together(self._comm, error)
        everyone = self._comm.allgather((A_SS, blocks))
        self._exists = all(blocks is not None for _, blocks in everyone)
        if self._exists:
            self._factorise_common(everyone)
        counts = len(self._groups), sum(group.copies for group in self._groups)
        factors, parts = sum_over_ranks(self._comm, np.array(counts))
        self.factors = int(factors), int(parts)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side. Collective."""
        x.array[:] = self.solve_many(b.array_r[:, None])[:, 0]

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, this rank's rows, shape (n, k). Collective."""
        self.iterations += B.shape[1]
        with np.errstate(invalid="ignore"):  # where there is no factor there are no numbers
            return self._solve(B)

    def destroy(self) -> None:
        """Free all factors."""
        for thing in (*self._groups, *self._common[::-1]):
            thing.destroy()
        self._groups, self._common = [], ()

    def _solve(self, B: Array) -> Array:
        """Solutions, shape (n, k)."""
        if not self._exists:
            return np.full_like(B, np.nan)
        inner = B[self._i] if self._S.size else B
        solved = [group.solve(inner) for group in self._groups]
        x_S = np.zeros((self._all_S.size, B.shape[1]))
        if self._common:
            x_S[self._mine] = B[self._S]
            for group, x in zip(self._groups, solved, strict=True):
                group.push(x, x_S)
            x_S = self._common[1].solve_many(sum_over_ranks(self._comm, x_S))
        inner = np.empty_like(inner)
        for group, x in zip(self._groups, solved, strict=True):
            group.place(x, x_S, inner)
        if not self._S.size:
            return inner
        X = np.empty_like(B)
        X[self._i], X[self._S] = inner, x_S[self._mine]
        return X

    def _take_apart(self) -> tuple[list[CongruentParts], csr_matrix]:
        """Congruent parts of this rank, nothing factorised, and this rank's rows of A_SS."""
        A_ii, A_iS, A_SS = self._find_blocks()
        own = Nodes(self._positions[~self._shared], self.rotations[:, :, ~self._shared])
        S = self._gather_shared_nodes()
        found = []
        for group in find_groups(A_ii, own.positions, own.rotations):
            touched = [np.unique(A_iS[dofs_of(copy.nodes)].indices // 3) for copy in group]
            while group:
                around, T_S = find_surroundings(group, own, S, touched)
                rows, alike = dofs_of(group[0].nodes), len(around)
                found.append((group[:alike], A_ii[rows][:, rows], A_iS[rows], around, T_S))
                group, touched = group[alike:], touched[alike:]
                group = [copy.relative_to(group[0]) for copy in group]
        return [CongruentParts(*parts, self._prefix) for parts in found], A_SS

    def _find_blocks(self) -> tuple[csr_matrix, csr_matrix, csr_matrix]:
        """A_ii and A_iS of this rank, and its rows of A_SS."""
        if not self._all_S.size:
            own = from_petsc(self._matrix.getDiagonalBlock())
            return own, csr_matrix((own.shape[0], 0)), csr_matrix((0, 0))
        first = self._matrix.getOwnershipRange()[0]
        rows = (first + self._i, first + self._S, self._all_S)
        i, S_mine, S = (
            PETSc.IS().createGeneral(r.astype(PETSc.IntType), comm=PETSc.COMM_SELF) for r in rows
        )
        blocks = self._matrix.createSubMatrices([i, i, S_mine], [i, S, S])
        copies = [from_petsc(block) for block in blocks]
        for thing in (*blocks, i, S_mine, S):
            thing.destroy()
        return copies[0], copies[1], copies[2]

    def _gather_shared_nodes(self) -> Nodes:
        """Nodes of S, of all ranks."""
        mine = self._positions[self._shared], self.rotations[:, :, self._shared]
        X, R = zip(*self._comm.allgather(mine), strict=True)
        return Nodes(np.concatenate(X), np.concatenate(R, axis=2))

    def _factorise_common(self, parts: list[Any]) -> None:
        """Add up the matrix of S from the parts of all ranks, and factorise it."""
        S = vstack([rows for rows, _ in parts]).tocoo()
        entries, i, j = [S.data], [S.row], [S.col]
        for _, blocks in parts:
            for columns, block in blocks:
                entries.append(-block.ravel())
                i.append(np.repeat(columns, columns.size))
                j.append(np.tile(columns, columns.size))
        indices = np.concatenate(i), np.concatenate(j)
        A = csr_matrix((np.concatenate(entries), indices), S.shape)
        if A.nnz:
            matrix = to_petsc(A)
            self._common = matrix, SymmetricFactor(matrix, self._prefix)
            self._common[1].update()


def free_factor(
    flexible: FlexibleModel, coupling: CouplingBlock, matrix: PETSc.Mat, free: PETSc.IS, prefix: str
) -> FreeSolver:
    """`Substructures` of several components, or if ranks meet in few unknowns; else one factor."""
    nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
    shared = find_shared_nodes(flexible)[nodes]
    parts = Substructures(matrix, flexible.positions[nodes], shared, prefix)
    return parts if parts.pays_off() else SymmetricFactor(matrix, prefix)


def find_shared_nodes(flexible: FlexibleModel) -> Mask:
    """Which of the nodes of this rank belong to cells of several ranks, shape (n_owned,)."""
    cells = flexible.body.mesh.topology.index_map(3).size_local
    met = np.zeros((len(flexible.local_positions), 3))
    met[np.unique(_compat.dofs_of_cells(flexible.space)[:cells])] = 1.0
    shared: Mask = flexible.sum_at_owners(met)[:, 0] > 1.5
    return shared
