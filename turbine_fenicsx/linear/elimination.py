"""Exact elimination of contact nodes and coupling multipliers, with a sparse LU of the rest.

A contact node follows its rigid body, u_c = P r - b_c with P = S^T B, so that contact
displacements and multipliers drop out. With A_II the rows and columns of A_uu that belong to free
nodes I, and Z = P - A_II^{-1} (A_uu P)_I the response of the flexible body to unit motions of its
carriers (twelve columns each),

    (K_r + P^T A_uu Z) r = b_r - P^T (A_uu w - b_u),   w = (A_II^{-1} (b_I + A_Ic b_c), -b_c),
    u = w + Z r,                                       mu_c = (A_uu u - b_u)_c.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.coupling import CouplingBlock
from turbine_fenicsx.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.linear.dense import solve_scaled
from turbine_fenicsx.linear.factor import SparseLU
from turbine_fenicsx.rotations import Array


class Elimination:
    """Direct solver of the nested tangent by elimination.

    Args:
        step: The step whose tangent is solved with.
        prefix: Options prefix of the sparse factorisations.
    """

    def __init__(self, step: EnergyMomentumStep, prefix: str) -> None:
        """Set up the eliminations of all flexible bodies."""
        system = step.system
        self._step = step
        self._bodies = [
            _BodyElimination(f, c, f"{prefix}free_")
            for f, c in zip(system.flexible_blocks, system.coupling_blocks, strict=True)
        ]
        self._reduced: Array = np.zeros((0, 0))

    def update(self) -> None:
        """Factorise A_II of each body and form the reduced matrix on rank 0."""
        reduced = self._step.rigid_tangent.copy()
        for body in self._bodies:
            schur = body.update()
            if schur is not None:
                reduced[np.ix_(body.coupling.columns, body.coupling.columns)] += schur
        self._reduced = reduced

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        b_u, b_c, b_r = self._step.split(b)
        u, mu_c, r = self._step.split(x)
        b_r.copy(r)
        for body, b_u_k, b_c_k, w in zip(self._bodies, b_u, b_c, u, strict=True):
            body.eliminate(b_u_k, b_c_k, w, r)
        if self._reduced.size:
            r.array[:] = solve_scaled(self._reduced, r.array_r)
        motion = self._step.system.comm.bcast(np.array(r.array_r) if self._reduced.size else None)
        for body, b_u_k, u_k, mu_k in zip(self._bodies, b_u, u, mu_c, strict=True):
            body.substitute(motion, b_u_k, u_k, mu_k)

    def destroy(self) -> None:
        """Free all PETSc objects."""
        for body in self._bodies:
            body.destroy()


class _BodyElimination:
    """The elimination of one flexible body."""

    def __init__(self, flexible: FlexibleBlock, coupling: CouplingBlock, prefix: str) -> None:
        """Find the free nodes and allocate the columns."""
        self.coupling = coupling
        self._A = flexible.tangent
        self._comm = flexible.body.mesh.comm
        contact = coupling.dofs
        free = np.setdiff1d(np.arange(3 * flexible.n_owned), contact)
        first = self._A.getOwnershipRange()[0]
        self._contact, self._free = contact, free
        self._free_set = PETSc.IS().createGeneral(
            (first + free).astype(PETSc.IntType), comm=self._comm
        )
        self._A_II = self._A.createSubMatrix(self._free_set, self._free_set)
        self._factor = SparseLU(self._A_II, prefix)
        self._b_I, self._x_I = self._A_II.createVecs()
        self._work, self._product = flexible.new_vector(), flexible.new_vector()
        n_columns = coupling.columns.size
        self._P = np.zeros((3 * flexible.n_owned, n_columns))
        self._P[contact] = coupling.B_local
        self._Z = np.zeros_like(self._P)

    def update(self) -> Array | None:
        """Factorise, compute Z, and return P^T A Z on rank 0 (None on the others)."""
        self._A.createSubMatrix(self._free_set, self._free_set, submat=self._A_II)
        self._factor.update()
        self._Z[:] = self._P
        schur = np.zeros((self.coupling.columns.size,) * 2)
        for k in range(schur.shape[1]):
            self._work.array[:] = self._P[:, k]
            self._A.mult(self._work, self._product)
            self._b_I.array[:] = self._product.array_r[self._free]
            self._factor.solve(self._b_I, self._x_I)
            self._Z[self._free, k] = -self._x_I.array_r
            self._work.array[:] = self._Z[:, k]
            self._A.mult(self._work, self._product)
            schur[:, k] = self.coupling.B_local.T @ self._product.array_r[self._contact]
        return self._comm.reduce(schur, root=0)

    def eliminate(self, b_u: PETSc.Vec, b_c: PETSc.Vec, w: PETSc.Vec, r: PETSc.Vec) -> None:
        """Compute w, and subtract P^T (A w - b_u) from the right-hand side in r."""
        w.set(0.0)
        w.array[self._contact] = -b_c.array_r
        self._A.mult(w, self._product)
        self._b_I.array[:] = (b_u.array_r - self._product.array_r)[self._free]
        self._factor.solve(self._b_I, self._x_I)
        w.array[self._free] = self._x_I.array_r
        self._A.mult(w, self._product)
        forces = (self._product.array_r - b_u.array_r)[self._contact]
        total = self._comm.reduce(self.coupling.B_local.T @ forces, root=0)
        if total is not None:
            r.array[self.coupling.columns] -= total

    def substitute(self, motion: Array, b_u: PETSc.Vec, u: PETSc.Vec, mu_c: PETSc.Vec) -> None:
        """Add Z r to w in u, and compute the multipliers."""
        u.array[:] += self._Z @ motion[self.coupling.columns]
        self._A.mult(u, self._product)
        mu_c.array[:] = (self._product.array_r - b_u.array_r)[self._contact]

    def destroy(self) -> None:
        """Free all PETSc objects."""
        self._factor.destroy()
        for thing in (self._A_II, self._b_I, self._x_I, self._work, self._product, self._free_set):
            thing.destroy()
