"""Congruent parts of a body on one rank: one factor, and one response to what surrounds them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.congruence import SAME_PLACE, Copy
from turbine_fenicsx.linear_solvers.factor import to_petsc
from turbine_fenicsx.linear_solvers.frames import turn
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor

Indices = npt.NDArray[np.int64]

SLAB = 16
"""Rows of the slab for each column of W: the number of layers of a slender body."""

NEGLIGIBLE = 1e-6
"""Singular values of the forces beyond the slab, relative to the largest, that are left out."""


@dataclass(frozen=True)
class Nodes:
    """Nodes where they were initially.

    Args:
        positions: Shape (n, 3) [m].
        rotations: Rotations of the material around each since then, shape (3, 3, n).
    """

    positions: Array
    rotations: Array


class CongruentParts:
    """Parts i of a body that a rigid motion takes to one another, with the nodes S around them.

    With A' = T A T^T of another part A', one factor of A and one W = A_ii^{-1} A_iS serve all
    parts. Each is read from memory once and has a right-hand side for each part, which takes most
    of a solve: three blades of 23 328 unknowns take 17 ms instead of 40 with separate factors.

    W has a column for each unknown of S around a part. By Saint-Venant's principle they look alike
    far from S: motions of whole cross-sections. With a slab s of rows next to S and the rows o
    beyond it

        W = (W_s, 0) - A_ii^{-1} (0, A_os W_s),      W_s = A_ss^{-1} A_sS.

    The forces A_os W_s that S exerts beyond the slab therefore have a low rank, and only as many
    solutions with the large factor are needed. W has a relative error of about `NEGLIGIBLE`.

    Args:
        A_iS: Its rows of the matrix, of all columns S.
        around: Nodes of S around each part in the order of those around the first, shape (n,) each.
        T_S: T at those nodes, shape (3, 3, n) each.

    Attributes:
        copies: Number of parts.
        columns: Unknowns of S around each part, shape (n,) each.
    """

    def __init__(
        self,
        copies: list[Copy],
        A_ii: csr_matrix,
        A_iS: csr_matrix,
        around: list[Indices],
        T_S: list[Array],
        prefix: str,
    ) -> None:
        """Nothing is factorised yet."""
        self.copies, self._size = len(copies), A_ii.shape[0]
        self.columns = [dofs_of(nodes) for nodes in around]
        self._dofs = dofs_of(np.concatenate([copy.nodes for copy in copies]))
        self._T = np.concatenate([copy.rotation for copy in copies], axis=2)
        self._T_S = np.concatenate(T_S, axis=2)
        self._all_columns = np.concatenate(self.columns)
        self._prefix, self._matrix = prefix, to_petsc(A_ii)
        # for `factorise`; without S it needs no more than the factor
        self._sparse = (A_ii, A_iS[:, self.columns[0]]) if self._all_columns.size else None
        self._factor = SymmetricFactor(self._matrix, prefix)

    def factorise(self) -> list[Array]:
        """Factorise and find W; returns A_Si W of each part. To be called once."""
        self._factor.update()
        if self._sparse is None:
            return [np.zeros((0, 0))] * self.copies
        (A_ii, A_iS), self._sparse = self._sparse, None
        self._edge = np.flatnonzero(np.diff(A_iS.indptr))
        self._A_Se = A_iS[self._edge].T.tocsr()
        self._slab = _collect_layers(A_ii, self._edge, SLAB * A_iS.shape[1])
        W = self._respond(A_ii[self._slab][:, self._slab], A_iS[self._slab].toarray(order="F"))
        far, modes = self._respond_beyond(A_ii, W)
        W_e = W[np.searchsorted(self._slab, self._edge)] + far[self._edge] @ modes
        # single precision is as accurate as the rest, and half the memory
        self._W, self._far, self._modes = (
            np.ascontiguousarray(M.T, np.float32) for M in (W, far, modes)
        )
        block = (self._A_Se @ W_e).reshape(-1, 3, A_iS.shape[1] // 3, 3)
        if not np.all(np.isfinite(block)):  # they have singular values all the same, or have not
            raise np.linalg.LinAlgError("there is no factor")
        T_S = np.split(self._T_S, self.copies, axis=2)
        turned = [np.einsum("ian,namb,jbm->nimj", T, block, T, optimize=True) for T in T_S]
        return [B.reshape((A_iS.shape[1],) * 2) for B in turned]

    def solve(self, B: Array) -> Array:
        """Solve for right-hand sides of all parts as if S were fixed.

        Args:
            B: Right-hand sides, shape (n, k) with all unknowns of the rank that are not in S.

        Returns:
            Solutions in the frames of the first part, shape (copies k, size).
        """
        b: Array = self._to_first(self._T, B[self._dofs])
        loaded = b.any(axis=1)
        if loaded.all():
            return self._factor.solve_many(b.T).T
        x: Array = np.zeros_like(b)
        if loaded.any():
            x[loaded] = self._factor.solve_many(b[loaded].T).T
        return x

    def push(self, x: Array, b_S: Array) -> None:
        """Subtract the forces of solutions on S, b_S <- b_S - A_Si x, shape (S, k)."""
        if self._all_columns.size:
            forces = self._from_first(self._T_S, (self._A_Se @ x[:, self._edge].T).T, b_S.shape[1])
            for columns, part in zip(self.columns, np.split(forces, self.copies), strict=True):
                b_S[columns] -= part

    def place(self, x: Array, x_S: Array, X: Array) -> None:
        """Put x - W x_S where it belongs in X, shape (n, k), in the frames of each part."""
        if self._all_columns.size:
            near = self._to_first(self._T_S, x_S[self._all_columns]).astype(np.float32)
            x[:, self._slab] -= near @ self._W
            x -= (near @ self._modes) @ self._far
        X[self._dofs] = self._from_first(self._T, x, X.shape[1])

    def destroy(self) -> None:
        """Free everything."""
        self._factor.destroy()
        self._matrix.destroy()

    def _to_first(self, T: Array, B: Array) -> Array:
        """T^T b of each part and column of B, shape (copies n, k), as rows, (copies k, n)."""
        if self.copies == 1:
            alone: Array = np.ascontiguousarray(B.T)
            return alone
        turned = turn(T, B.T, inverse=True).reshape(B.shape[1], self.copies, -1)
        rows: Array = turned.swapaxes(0, 1).reshape(B.shape[1] * self.copies, -1)
        return rows

    def _from_first(self, T: Array, rows: Array, k: int) -> Array:
        """T x of rows as `_to_first` returns them, shape (copies n, k)."""
        if self.copies == 1:
            same: Array = rows.T
            return same
        by_column = rows.reshape(self.copies, k, -1).swapaxes(0, 1)
        return turn(T, by_column.reshape(k, -1)).T

    def _respond(self, A_ss: csr_matrix, forces: Array) -> Array:
        """A_ss^{-1} times some forces; the matrix is factorised for this alone."""
        if not forces.size:
            return forces
        A = to_petsc(A_ss)
        factor = SymmetricFactor(A, self._prefix)
        factor.update()
        response = factor.solve_many(forces)
        factor.destroy()
        A.destroy()
        return response

    def _respond_beyond(self, A_ii: csr_matrix, W: Array) -> tuple[Array, Array]:
        """Factors of -A_ii^{-1} (0, A_os W_s), shapes (i, rank) and (rank, columns)."""
        o = np.setdiff1d(np.arange(self._size), self._slab)
        A_os = A_ii[self._slab][:, o].T.tocsr()
        loaded = np.flatnonzero(np.diff(A_os.indptr))
        U, s, V = np.linalg.svd(A_os[loaded] @ W, full_matrices=False)
        rank = int(np.sum(s > NEGLIGIBLE * np.max(s, initial=0.0)))
        forces = np.zeros((self._size, rank))
        forces[o[loaded]] = -U[:, :rank] * s[:rank]
        return self._factor.solve_many(forces) if rank else forces, V[:rank]


def find_surroundings(
    group: list[Copy], own: Nodes, S: Nodes, touched: list[Indices]
) -> tuple[list[Indices], list[Array]]:
    """Nodes of S around each part of a group in the order of those around the first, and T there.

    Args:
        own: Nodes of this rank that are not in S.
        touched: Nodes of S around each part in any order.

    Returns:
        Nodes and T of as many parts from the first on as are surrounded alike.
    """
    from scipy.spatial import cKDTree

    here, first = touched[0], own.positions[group[0].nodes]
    near = SAME_PLACE * np.max(np.ptp(first, axis=0))
    around, T = [here], [np.repeat(np.eye(3)[:, :, None], here.size, axis=2)]
    for copy, nodes in zip(group[1:], touched[1:], strict=True):
        moved = (S.positions[here] - first.mean(axis=0)) @ copy.motion.T
        moved += own.positions[copy.nodes].mean(axis=0)
        order = np.arange(here.size)
        if nodes.size:
            order = cKDTree(S.positions[nodes]).query(moved, distance_upper_bound=near)[1]
        if not np.array_equal(np.sort(order), np.arange(nodes.size)):
            break
        around.append(nodes[order])
        R, R_first = S.rotations[:, :, nodes[order]], S.rotations[:, :, here]
        T.append(np.einsum("ian,ab,jbn->ijn", R, copy.motion, R_first))
    return around, T


def dofs_of(nodes: Indices) -> Indices:
    """The three unknowns of each node."""
    dofs: Indices = (3 * nodes[:, None] + np.arange(3)).ravel()
    return dofs


def _collect_layers(A: csr_matrix, rows: Indices, size: int) -> Indices:
    """Rows and their neighbours, layer by layer until there are ``size`` of them; sorted."""
    inside = np.zeros(A.shape[0], dtype=bool)
    inside[rows] = True
    while rows.size and np.count_nonzero(inside) < size:
        neighbours = np.unique(A[rows].indices)
        rows = neighbours[~inside[neighbours]]
        inside[rows] = True
    return np.flatnonzero(inside)
