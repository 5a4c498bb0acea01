"""Exact elimination of contact nodes and coupling multipliers, with a sparse LU of the rest.

A contact node follows its rigid body, u_c = P r - b_c with P = S^T B, so that contact
displacements and multipliers drop out. With A_II the rows and columns of A_uu that belong to free
nodes I, and Z = Y - A_II^{-1} (A_uu Y)_I the response of the flexible body to unit motions of its
carriers (twelve columns each; any Y with Y_c = P_c gives the same Z, the motion of the whole body
with its carrier is the one that leaves least to solve),

    (K_r + P^T A_uu Z) r = b_r - P^T (A_uu w - b_u),   w = (A_II^{-1} (b_I + A_Ic b_c), -b_c),
    u = w + Z r,                                       mu_c = (A_uu u - b_u)_c.
"""

from __future__ import annotations

from collections.abc import Callable

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.dense import ScaledFactor, count_negative
from turbine_fenicsx.foundation.parallel import on_rank0, sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.blocks import Blocks
from turbine_fenicsx.linear_solvers.factor import FreeSolver, SparseFactor
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel


class Elimination:
    """Direct solver of the nested tangent, factorised anew in each Newton iteration.

    Args:
        blocks: The blocks of the tangent.
        prefix: Options prefix of the sparse factorisations.
        symmetric: Whether the tangent is symmetric, which halves work and memory.
    """

    def __init__(self, blocks: Blocks, prefix: str, symmetric: bool = False) -> None:
        """Set up the eliminations of all flexible bodies."""
        system = blocks.system
        self._blocks = blocks
        self._symmetric: list[SymmetricFactor] = []

        def factor(A: PETSc.Mat, free: PETSc.IS) -> FreeSolver:
            name = f"{prefix}free_"
            if not symmetric:
                return SparseFactor(A, name)
            self._symmetric.append(SymmetricFactor(A, name))
            return self._symmetric[-1]

        self._bodies = [
            BodyElimination(m, A, c, factor)
            for m, A, c in zip(
                system.flexible_models, blocks.tangents, system.coupling_blocks, strict=True
            )
        ]
        self._reduced_matrix = np.zeros((0, 0))
        self._reduced = ScaledFactor(self._reduced_matrix)
        self._solves = 0

    @property
    def krylov_iterations(self) -> int:
        """Direct solves so far."""
        return self._solves

    def begin(self) -> None:
        """There is nothing to prepare: each update factorises anew."""

    def end(self, converged: bool) -> bool:
        """There is nothing to learn from the iteration."""
        return False

    def save(self) -> RestartData:
        """Empty data: nothing is kept between steps."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """There is nothing to restore."""

    def update(self, x: PETSc.Vec) -> None:
        """Factorise A_II of each body at X and form the reduced matrix on rank 0."""
        self._blocks.tangent(x)
        reduced = self._blocks.rigid_tangent.copy()
        for body in self._bodies:
            body.factorise()
            if reduced.size:
                reduced[np.ix_(body.columns, body.columns)] += body.schur
        self._reduced, self._reduced_matrix = ScaledFactor(reduced), reduced

    def count_negative(self) -> int:
        """Number of negative eigenvalues of a symmetric tangent, without the couplings.

        By Sylvester's law, the same as those of all A_II and of the reduced matrix. Independent
        constraints in K_r have one each. Collective; only for what was made as symmetric.
        """
        inner = sum(factor.count_negative() for factor in self._symmetric)
        comm = self._blocks.system.comm
        return inner + on_rank0(comm, lambda: count_negative(self._reduced_matrix))

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        self._solves += 1
        b_u, b_c, b_r = self._blocks.split(b)
        u, mu_c, r = self._blocks.split(x)
        b_r.copy(r)
        for body, b_u_k, b_c_k, w in zip(self._bodies, b_u, b_c, u, strict=True):
            forces = body.eliminate(b_u_k.array_r, b_c_k.array_r, w.array)
            if r.array_r.size:
                r.array[body.columns] -= forces
        motion = self._blocks.solve_rigid(self._reduced, r)
        for body, b_u_k, u_k, mu_k in zip(self._bodies, b_u, u, mu_c, strict=True):
            mu_k.array[:] = body.substitute(motion[body.columns], b_u_k.array_r, u_k.array)

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
        columns: Columns of r that belong to the carriers.
        schur: P^T A_uu Z, shape (columns, columns), equal on all ranks.
        solver: The solver for A_II.
    """

    def __init__(
        self,
        flexible: FlexibleModel,
        tangent: PETSc.Mat,
        coupling: CouplingBlock,
        make_solver: Callable[[PETSc.Mat, PETSc.IS], FreeSolver],
    ) -> None:
        """Find the free nodes and allocate the columns."""
        self.columns = coupling.columns
        self._B = coupling.B_local
        self._A = tangent
        self._comm = flexible.body.mesh.comm
        self._contact = coupling.dofs
        self._free = np.setdiff1d(np.arange(3 * flexible.n_owned), coupling.dofs)
        first = self._A.getOwnershipRange()[0]
        self._free_set = PETSc.IS().createGeneral(
            (first + self._free).astype(PETSc.IntType), comm=self._comm
        )
        self._contact_set = PETSc.IS().createGeneral(
            (first + self._contact).astype(PETSc.IntType), comm=self._comm
        )
        self._all = PETSc.IS().createStride(
            3 * flexible.n_owned, first=first, step=1, comm=self._comm
        )
        self._A_II, self._A_Ic, self._A_c = (self._A.createSubMatrix(*p) for p in self._parts())
        self.solver = make_solver(self._A_II, self._free_set)
        self._b_I, self._x_I = self._A_II.createVecs()
        self._u, self._Au = flexible.new_vector(), flexible.new_vector()
        self._c, self._Ac = self._A_Ic.createVecRight(), self._A_c.createVecLeft()
        self._start = coupling.rigid_extension(flexible.positions)
        self._Z = np.zeros_like(self._start)
        self.schur: Array = np.zeros((self.columns.size,) * 2)

    @property
    def iterations(self) -> int:
        """Krylov iterations for the free nodes so far."""
        return self.solver.iterations

    def factorise(self) -> None:
        """Factorise A_II at the present values of A_uu and compute Z and the Schur complement."""
        for part, sets in zip((self._A_II, self._A_Ic, self._A_c), self._parts(), strict=True):
            self._A.createSubMatrix(*sets, submat=part)  # made anew where it was destroyed
        self.solver.update()
        self._Z[:] = self._start
        schur = np.zeros_like(self.schur)
        for first in range(0, self.columns.size, 12):  # carrier by carrier, to save memory
            columns = np.arange(first, first + 12)
            forces = np.empty((self._free.size, 12), order="F")
            for k in columns:
                self._u.array[:] = self._Z[:, k]
                self._A.mult(self._u, self._Au)
                forces[:, k - first] = self._Au.array_r[self._free]
            self._Z[np.ix_(self._free, columns)] -= self.solver.solve_many(forces)
            for k in columns:
                schur[:, k] = self._B.T @ self._contact_forces(self._Z[:, k])
        self.schur = sum_over_ranks(self._comm, schur)

    def eliminate(self, b_u: Array, b_c: Array, w: Array) -> Array:
        """Compute w, overwritten, and P^T (A w - b_u), summed over all ranks."""
        self._c.array[:] = b_c
        self._b_I.array[:] = b_u[self._free]
        self._A_Ic.multAdd(self._c, self._b_I, self._b_I)
        self.solver.solve(self._b_I, self._x_I)
        w[self._contact] = -b_c
        w[self._free] = self._x_I.array_r
        forces = self._contact_forces(w) - b_u[self._contact]
        return sum_over_ranks(self._comm, self._B.T @ forces)

    def substitute(self, motion: Array, b_u: Array, u: Array) -> Array:
        """Add Z r to w in u, for the motion r of the carriers, and return the multipliers."""
        u += self._Z @ motion
        forces: Array = self._contact_forces(u) - b_u[self._contact]
        return forces

    def destroy(self) -> None:
        """Free all PETSc objects."""
        self.solver.destroy()
        for matrix in (self._A_II, self._A_Ic, self._A_c):
            matrix.destroy()
        for vector in (self._b_I, self._x_I, self._u, self._Au, self._c, self._Ac):
            vector.destroy()
        for indices in (self._free_set, self._contact_set, self._all):
            indices.destroy()

    def _parts(self) -> list[tuple[PETSc.IS, PETSc.IS]]:
        """Rows and columns of A_II, A_Ic and the contact rows of A_uu."""
        free, contact = self._free_set, self._contact_set
        return [(free, free), (free, contact), (contact, self._all)]

    def _contact_forces(self, u: Array) -> Array:
        """(A_uu u)_c, owned entries."""
        self._u.array[:] = u
        self._A_c.mult(self._u, self._Ac)
        forces: Array = self._Ac.array_r
        return forces
