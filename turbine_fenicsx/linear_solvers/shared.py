"""One factor for all congruent components of a matrix."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.machine import give_back_memory
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.congruence import Copy, find_groups, label_components
from turbine_fenicsx.linear_solvers.factor import FreeSolver, copy_csr
from turbine_fenicsx.linear_solvers.frames import turn
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel


class SharedFactor(FreeSolver):
    """Solves with a symmetric matrix of unconnected components, of which some are congruent.

    Each group of them has one factor, that of its first, and a solve has a right-hand side for
    each: with A' = T A T^T the solution is x' = T A^{-1} T^T b'. A factor is read from memory once
    for all of them, which is what most of a solve takes: three blades of 23 328 unknowns take 17 ms
    for 40 with a factor of their own each.

    Args:
        matrix: The matrix, on one rank.
        positions: Initial positions of its nodes, shape (n, 3) [m].
        prefix: Options prefix of the factors.

    Attributes:
        rotations: Rotations of the material since then, shape (3, 3, n); set before `update`.
    """

    def __init__(self, matrix: PETSc.Mat, positions: Array, prefix: str) -> None:
        """Nothing is compared or factorised yet."""
        self._matrix, self._positions, self._prefix = matrix, positions, prefix
        self.rotations: Array = np.repeat(np.eye(3)[:, :, None], len(positions), axis=2)
        self._groups: list[_Group] = []
        self.iterations = 0

    def update(self) -> None:
        """Factorise the present values of the matrix, which is destroyed."""
        self.destroy()
        found = find_groups(copy_csr(self._matrix), self._positions, self.rotations)
        self._groups = [_Group(self._matrix, copies, self._prefix) for copies in found]
        self._matrix.destroy()
        give_back_memory()
        for group in self._groups:
            group.factorise()
        self.factors = len(found), sum(len(copies) for copies in found)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        b_, x_ = b.array_r, x.array
        for group in self._groups:
            group.solve(b_, x_)
        self.iterations += 1

    def solve_many(self, B: Array) -> Array:
        """Solutions for several right-hand sides, shape (n, k)."""
        X = np.zeros_like(B)
        for group in self._groups:
            group.solve_many(B, X)
        self.iterations += B.shape[1]
        return X

    def destroy(self) -> None:
        """Free the factors."""
        for group in self._groups:
            group.destroy()
        self._groups = []


def shared_factor(
    flexible: FlexibleModel, coupling: CouplingBlock, matrix: PETSc.Mat, free: PETSc.IS, prefix: str
) -> FreeSolver:
    """A `SharedFactor` where one rank holds several components, else a `SymmetricFactor`.

    Args:
        flexible: The body.
        coupling: Its couplings.
        matrix: A_II.
        free: Free degrees of freedom.
        prefix: Options prefix of the factors.
    """
    if matrix.getComm().getSize() > 1 or not np.any(label_components(*matrix.getRowIJ())):
        return SymmetricFactor(matrix, prefix)
    nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
    return SharedFactor(matrix, flexible.positions[nodes], prefix)


class _Group:
    """Congruent components, and the factor of the first.

    Attributes:
        copies: Their number.
    """

    def __init__(self, matrix: PETSc.Mat, copies: list[Copy], prefix: str) -> None:
        """Take what belongs to them out of the matrix; nothing is factorised yet."""
        self.copies, size = len(copies), 3 * len(copies[0].nodes)
        nodes = np.concatenate([copy.nodes for copy in copies])
        self._dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        self._T = np.concatenate([copy.rotation for copy in copies], axis=2)
        rows = PETSc.IS().createGeneral(self._dofs[:size].astype(PETSc.IntType), PETSc.COMM_SELF)
        self._matrix = matrix.createSubMatrix(rows, rows)
        rows.destroy()
        self._factor = SymmetricFactor(self._matrix, prefix)
        # a column for each component, one below the other in memory
        self._b, self._x = np.zeros(nodes.size * 3), np.zeros(nodes.size * 3)
        self._B, self._X = (
            PETSc.Mat().createDense((size, self.copies), array=v, comm=PETSc.COMM_SELF)
            for v in (self._b, self._x)
        )

    def factorise(self) -> None:
        """Factorise the first component."""
        self._factor.update()

    def solve(self, b: Array, x: Array) -> None:
        """Solve for one right-hand side of all components."""
        self._b[:] = turn(self._T, b[self._dofs], inverse=True)
        self._factor.solve_block(self._B, self._X)
        x[self._dofs] = turn(self._T, self._x)

    def solve_many(self, B: Array, X: Array) -> None:
        """Solve for several, shape (n, k), without those that are zero."""
        T = self._T.reshape(3, 3, self.copies, -1)
        shape = (self.copies, T.shape[3], 3, B.shape[1])
        b = np.einsum("jicn,cnjk->nick", T, B[self._dofs].reshape(shape))
        b = b.reshape(3 * shape[1], -1)
        loaded = np.any(b != 0.0, axis=0)
        x = np.zeros_like(b)
        if loaded.any():
            x[:, loaded] = self._factor.solve_many(b[:, loaded])
        x = np.einsum("ijcn,njck->cnik", T, x.reshape(shape[1], 3, self.copies, -1))
        X[self._dofs] = x.reshape(self._dofs.size, -1)

    def destroy(self) -> None:
        """Free everything."""
        self._factor.destroy()
        for thing in (self._B, self._X, self._matrix):
            thing.destroy()
