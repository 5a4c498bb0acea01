"""Exact elimination of contact nodes and multipliers of a body, with a sparse LU of the rest.

A contact node follows its rigid body, u_c = P r - b_c with P = S^T B, so that contact displacements
and multipliers drop out. A_II are the rows and columns of A_uu that belong to free nodes I. Z = Y -
A_II^{-1} (A_uu Y)_I is the response of the flexible body to unit motions of its parent bodies,
twelve columns each. Any Y with Y_c = P_c gives the same Z; the motion of the whole body with its
parent body leaves least to solve. Then

    (K_r + P^T A_uu Z) r = b_r - P^T (A_uu w - b_u),   w = (A_II^{-1} (b_I + A_Ic b_c), -b_c),
    u = w + Z r,                                       mu_c = (A_uu u - b_u)_c.
"""

from __future__ import annotations

from collections.abc import Callable

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock


class BodyElimination:
    """The elimination of one flexible body, for the values of its tangent at `factorise`.

    Args:
        make_solver: Makes the solver for A_II from the matrix and its free nodes.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: P^T A_uu Z, shape (columns, columns), equal on all ranks.
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
