"""Exact elimination of contact nodes and coupling multipliers, with a sparse LU of the rest.

A contact node follows its rigid body, u_c = P r - b_c with P = S^T B, so that contact displacements
and multipliers drop out. A_II are the rows and columns of A_uu that belong to free nodes I. Z = Y -
A_II^{-1} (A_uu Y)_I is the response of the flexible body to unit motions of its parent bodies,
twelve columns each. Any Y with Y_c = P_c gives the same Z; the motion of the whole body with its
parent body leaves least to solve. Then

    (K_r + P^T A_uu Z) r = b_r - P^T (A_uu w - b_u),   w = (A_II^{-1} (b_I + A_Ic b_c), -b_c),
    u = w + Z r,                                       mu_c = (A_uu u - b_u)_c.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.dense import ScaledFactor, count_negative
from turbine_fenicsx.foundation.parallel import on_rank0, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.base import DirectSolver
from turbine_fenicsx.linear_solvers.factor import FreeSolver, SparseFactor
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.nested_blocks import NestedBlocks


class EliminatedBody(Protocol):
    """A flexible body as the reduced equations see it.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: P^T A_uu Z, shape (columns, columns), equal on all ranks.
    """

    columns: npt.NDArray[np.int64]
    schur: Array

    def eliminate(self, b_u: Array, b_c: Array) -> Array:
        """Compute w, and return P^T (A w - b_u), summed over all ranks."""

    def substitute(self, motion: Array) -> tuple[Array, Array]:
        """Return u and mu_c for the motion r of the parent bodies; after `eliminate`."""


class ReducedEquations:
    """The equations of the rigid part, and the bodies that follow from its motion.

    Args:
        blocks: The blocks of the tangent.
        bodies: The flexible bodies.

    Attributes:
        matrix: K_r + P^T A_uu Z on rank 0, empty on the others, set by `update`.
    """

    def __init__(self, blocks: NestedBlocks, bodies: Sequence[EliminatedBody]) -> None:
        """Nothing is reduced yet."""
        self._blocks, self._bodies = blocks, bodies
        self.matrix: Array = np.zeros((0, 0))

    def update(self) -> None:
        """Form and factorise the matrix for the present K_r and Schur complements."""
        self.matrix = self._blocks.rigid_tangent.copy()
        if self.matrix.size:
            for body in self._bodies:
                # K_r + P^T A_uu Z
                self.matrix[np.ix_(body.columns, body.columns)] += body.schur
        self._factor = ScaledFactor(self.matrix)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        b_u, b_c, b_r = self._blocks.split(b)
        u, mu_c, r = self._blocks.split(x)
        b_r.copy(r)
        for body, b_u_k, b_c_k in zip(self._bodies, b_u, b_c, strict=True):
            forces = body.eliminate(b_u_k.array_r, b_c_k.array_r)
            if r.array_r.size:
                r.array[body.columns] -= forces
        motion = self._blocks.solve_rigid(self._factor, r)
        for body, u_k, mu_k in zip(self._bodies, u, mu_c, strict=True):
            u_k.array[:], mu_k.array[:] = body.substitute(motion[body.columns])


class Elimination(DirectSolver):
    """Direct solver of the nested tangent, refactorised in each Newton iteration.

    Args:
        blocks: The blocks of the tangent.
        prefix: Options prefix of the sparse factorisations.
        symmetric: Whether the tangent is symmetric, which halves work and memory.
    """

    def __init__(self, blocks: NestedBlocks, prefix: str, symmetric: bool = False) -> None:
        """Set up the eliminations of all flexible bodies."""
        system, kind = blocks.system, SymmetricFactor if symmetric else SparseFactor
        self._blocks = blocks
        self._factors: list[SparseFactor] = []

        def factor(A: PETSc.Mat, free: PETSc.IS) -> FreeSolver:
            self._factors.append(kind(A, f"{prefix}free_"))
            return self._factors[-1]

        self._bodies = [
            BodyElimination(m, A, c, factor)
            for m, A, c in zip(
                system.flexible_models, blocks.tangents, system.coupling_blocks, strict=True
            )
        ]
        self._reduced = ReducedEquations(blocks, self._bodies)

    def update(self, x: PETSc.Vec) -> None:
        """Factorise A_II of each body at X and form the reduced matrix on rank 0."""
        self._blocks.tangent(x)
        for body in self._bodies:
            body.factorise()
        self._reduced.update()

    def count_negative(self) -> int:
        """Number of negative eigenvalues of a symmetric tangent, without the couplings.

        By Sylvester's law, the same as those of all A_II and of the reduced matrix. Independent
        constraints in K_r have one each. Collective; only for what was made as symmetric.
        """
        inner = sum(factor.count_negative() for factor in self._factors)
        comm = self._blocks.system.comm
        return inner + on_rank0(comm, lambda: count_negative(self._reduced.matrix))

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        self.krylov_iterations += 1
        self._reduced.solve(b, x)

    def destroy(self) -> None:
        """Free all PETSc objects."""
        for body in self._bodies:
            body.destroy()


class BodyElimination:
    """The elimination of one flexible body, for the values of its tangent at `factorise`.

    Args:
        flexible: The flexible body.
        tangent: A_uu.
        coupling: Its couplings.
        make_solver: Makes the solver for A_II from the matrix and its free nodes.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: P^T A_uu Z, shape (columns, columns), equal on all ranks.
        solver: The solver for A_II.
    """

    def __init__(
        self,
        flexible: BodyModel,
        tangent: PETSc.Mat,
        coupling: CouplingBlock,
        make_solver: Callable[[PETSc.Mat, PETSc.IS], FreeSolver],
    ) -> None:
        """Find the free nodes and allocate the columns."""
        self.columns = coupling.columns
        self._A, self._B, self._comm = tangent, coupling.B_local, flexible.comm
        self._contact = coupling.dofs
        self._free = np.setdiff1d(np.arange(3 * flexible.n_owned), self._contact)
        first = tangent.getOwnershipRange()[0]
        free, contact = self._sets = [
            PETSc.IS().createGeneral((first + dofs).astype(PETSc.IntType), comm=self._comm)
            for dofs in (self._free, self._contact)
        ]
        self._parts = [(free, free), (free, contact), (contact, None)]  # A_II, A_Ic, A_c
        self._A_II, self._A_Ic, self._A_c = (tangent.createSubMatrix(*p) for p in self._parts)
        self.solver = make_solver(self._A_II, free)
        self._x_I, self._b_I = self._A_II.createVecs()
        self._u, self._c = self._A_c.createVecs()
        self._b_contact = np.zeros(self._contact.size)
        self._start = coupling.rigid_extension(flexible)
        self._Z = np.zeros_like(self._start)
        self.schur: Array = np.zeros((self.columns.size,) * 2)

    def factorise(self) -> None:
        """Factorise A_II at the present values of A_uu and compute Z and the Schur complement."""
        for part, sets in zip((self._A_II, self._A_Ic, self._A_c), self._parts, strict=True):
            self._A.createSubMatrix(*sets, submat=part)  # made anew where it was destroyed
        self.solver.update()
        self._Z[:] = self._start
        schur, Au = np.zeros_like(self.schur), self._u.duplicate()
        for first in range(0, self.columns.size, 12):  # carrier by carrier, to save memory
            columns = np.arange(first, first + 12)
            forces = np.empty((self._free.size, 12), order="F")
            for k in columns:
                self._u.array[:] = self._Z[:, k]
                self._A.mult(self._u, Au)
                forces[:, k - first] = Au.array_r[self._free]
            self._Z[np.ix_(self._free, columns)] -= self.solver.solve_many(forces)
            for k in columns:
                self._u.array[:] = self._Z[:, k]
                schur[:, k] = self._B.T @ self._contact_forces()
        self.schur = sum_over_ranks(self._comm, schur)
        Au.destroy()

    def eliminate(self, b_u: Array, b_c: Array) -> Array:
        """Compute w, and return P^T (A w - b_u), summed over all ranks."""
        self._c.array[:] = b_c
        self._b_I.array[:] = b_u[self._free]
        # w = (A_II^-1 (b_I + A_Ic b_c), -b_c)
        self._A_Ic.multAdd(self._c, self._b_I, self._b_I)
        self.solver.solve(self._b_I, self._x_I)
        self._u.array[self._contact] = -b_c
        self._u.array[self._free] = self._x_I.array_r
        self._b_contact = b_u[self._contact]
        return sum_over_ranks(self._comm, self._B.T @ (self._contact_forces() - self._b_contact))

    def substitute(self, motion: Array) -> tuple[Array, Array]:
        """Return u = w + Z r for the motion r of the parent bodies, and the multipliers."""
        # u = w + Z r, mu_c = (A_uu u - b_u)_c
        self._u.array[:] += self._Z @ motion
        return self._u.array_r, self._contact_forces() - self._b_contact

    def destroy(self) -> None:
        """Free all PETSc objects."""
        vectors = self._x_I, self._b_I, self._u, self._c
        for thing in (self.solver, self._A_II, self._A_Ic, self._A_c, *vectors, *self._sets):
            thing.destroy()

    def _contact_forces(self) -> Array:
        """(A_uu u)_c, owned entries."""
        self._A_c.mult(self._u, self._c)
        forces: Array = self._c.array_r
        return forces
