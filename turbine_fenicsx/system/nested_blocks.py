"""Nested vectors and matrices of a system: flexible bodies, their couplings, the rigid part.

Unknowns X = (u | mu_c | r) are for every flexible body its displacements and coupling multipliers,
and one small block r of rigid bodies, joints and joint coordinates, which rank 0 owns. With one
flexible body a matrix is

    | A_uu  C^T  0   |
    | C     0    B   |
    | 0     B^T  K_r |
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.dense import ScaledFactor
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.system import MultibodySystem


class NestedBlocks(ABC):
    """One nested matrix, and vectors that fit.

    Attributes:
        rigid_tangent: K_r on rank 0, shape (n_r, n_r); empty on the others.
        transposed: C^T and B^T of each flexible body.
        n_r: Number of rigid unknowns of this rank.
    """

    def __init__(self, system: MultibodySystem, tangents: tuple[PETSc.Mat, ...]) -> None:
        self.system, self.tangents = system, tangents
        comm, n, k = system.comm, system.rigid_model.size, len(tangents)
        self.n_r = n if comm.rank == 0 else 0
        self._K = PETSc.Mat().createDense(((self.n_r, n), (self.n_r, n)), comm=comm)
        self._K.setUp()
        self._K.assemble()
        blocks: list[list[PETSc.Mat | None]] = [[None] * (2 * k + 1) for _ in range(2 * k + 1)]
        self.transposed = []
        for i, (A, c) in enumerate(zip(tangents, system.coupling_blocks, strict=True)):
            C_T, B_T = c.C.transpose(PETSc.Mat()), c.B.transpose(PETSc.Mat())
            self.transposed.append((C_T, B_T))
            blocks[i][i], blocks[i][k + i], blocks[k + i][i] = A, C_T, c.C
            blocks[k + i][2 * k], blocks[2 * k][k + i] = c.B, B_T
        blocks[2 * k][2 * k] = self._K
        self.tangent_matrix = PETSc.Mat().createNest(blocks, comm=comm)
        self.tangent_matrix.setUp()
        self.rigid_tangent = np.zeros((self.n_r, self.n_r))

    @abstractmethod
    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble all blocks at the unknowns X."""

    def turn_tangents(self, x: PETSc.Vec) -> list[tuple[Array | None, Array]] | None:
        """Take the last tangent of each body to the unknowns X.

        Returns:
            Rotations of its copies, shape (copies, 3, 3), None where the last ones stay, and what
            is added to its right-hand side. With rotations K_r is assembled, too. None in place of
            all where a new tangent is needed, as by default.
        """
        return None

    def new_nested_vector(self) -> PETSc.Vec:
        """New nested vector with the layout of the unknowns, zero."""
        system = self.system
        parts = [m.new_vector() for m in system.flexible_models]
        parts += [c.C.createVecLeft() for c in system.coupling_blocks]
        parts.append(PETSc.Vec().createMPI((self.n_r, system.rigid_model.size), comm=system.comm))
        for part in parts:
            part.set(0.0)
        return PETSc.Vec().createNest(parts, comm=system.comm)

    def split(self, x: PETSc.Vec) -> tuple[list[PETSc.Vec], list[PETSc.Vec], PETSc.Vec]:
        """Parts (u of each body, mu_c of each body, r) of a nested vector."""
        parts = x.getNestSubVecs()
        k = len(self.tangents)
        return parts[:k], parts[k : 2 * k], parts[2 * k]

    def set_rigid_tangent(self, K: Array) -> None:
        """Set K_r, given on rank 0. Collective."""
        if self.n_r:
            self.rigid_tangent = K
            self._K.getDenseArray()[:] = K
        self._K.assemble()
        self.tangent_matrix.assemble()

    def solve_rigid(self, reduced: ScaledFactor, r: PETSc.Vec) -> Array:
        """Solve the reduced equations on rank 0, overwriting r, and hand r to all ranks.

        Args:
            reduced: K_r with the Schur complements of the flexible bodies, on rank 0; empty on
                the others.

        Returns:
            The solution, shape (n_r,), on every rank.
        """
        if self.n_r:
            r.array[:] = reduced.solve(r.array_r)
        return self.on_all_ranks(r)

    def on_all_ranks(self, r: PETSc.Vec) -> Array:
        """The rigid part of a vector, a copy on every rank."""
        values = np.array(r.array_r) if self.n_r else np.empty(self.system.rigid_model.size)
        return from_rank0(self.system.comm, values)
