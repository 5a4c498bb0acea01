"""Exact elimination of contact nodes and multipliers of a body with a small dense tangent.

The equations are those of `BodyElimination`, for each diagonal block of the tangent by itself.
Rank 0 owns all.

A factor also serves for a body that has turned since. With the rotation Q of a copy, Q^T takes all
vectors into the frame of the factor, those of parent bodies too, and Q takes them back.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock


class DenseElimination:
    """The elimination of one body, for the values of its tangent at `factorise`.

    Args:
        model: The body.
        tangent: A_uu, a dense matrix with a diagonal block for each copy of the body.
        coupling: Its couplings.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: P^T A_uu Z, shape (columns, columns), on rank 0; zero on the others.
    """

    def __init__(self, model: BodyModel, tangent: PETSc.Mat, coupling: CouplingBlock) -> None:
        self.columns, self._A, self._B = coupling.columns, tangent, coupling.B_local
        self.schur: Array = np.zeros((self.columns.size,) * 2)
        self._start = coupling.rigid_extension(model)
        self._u = np.zeros(3 * model.n_owned)
        contact = coupling.dofs
        self._contact, self._b_contact = contact, np.zeros(contact.size)
        self._lacking: Array | float = 0.0
        self._is_factorised = False
        self._copies: list[_Copy] = []
        k = model.dense_block
        for first in range(0, 3 * model.n_owned, k):
            mine = np.flatnonzero((contact >= first) & (contact < first + k))
            moved = np.flatnonzero(self._start[first : first + k].any(axis=0))
            columns = slice(moved[0], moved[-1] + 1) if moved.size else slice(0)
            rows = slice(first, first + k)
            self._copies.append(_Copy(rows, columns, contact[mine] - first, mine))

    def factorise(self) -> None:
        """Factorise A_II of each copy and compute Z and the Schur complement."""
        dense = self._A.getDenseArray() if self._copies else np.zeros((0, 0))
        for copy in self._copies:
            copy.factorise(dense[copy.rows, copy.rows])
            k = copy.columns
            Z = np.array(self._start[copy.rows, k], order="F")
            Z[copy.free] -= copy.solve((copy.A @ Z)[copy.free])
            copy.Z, copy.schur = Z, self._B[copy.held, k].T @ (copy.A[copy.contact] @ Z)
        self._is_factorised = True
        self.turn(np.broadcast_to(np.eye(3), (len(self._copies), 3, 3)), 0.0)

    def turn(self, Q: Array | None, lacking: Array | float) -> None:
        """Use the factors, made now if there are none, for copies that have turned since.

        Args:
            Q: Rotation of each copy since its tangent was made, shape (copies or 0, 3, 3); None
                for the last one.
            lacking: What is added to each b_u that follows, shape (3 n_owned,).
        """
        if not self._is_factorised:
            self.factorise()
        self._lacking = lacking
        if Q is None:
            return
        self.schur = np.zeros_like(self.schur)
        for copy, turn in zip(self._copies, Q, strict=True):
            copy.Q, k, n = turn, copy.columns, len(copy.schur)
            # Q S Q^T for the vectors of the parent bodies
            half = (copy.schur.reshape(n, n // 3, 3) @ turn.T).reshape(n, n)
            self.schur[k, k] += (half.T.reshape(n, n // 3, 3) @ turn.T).reshape(n, n).T

    def forget(self) -> None:
        """There are no factors of the present tangent."""
        self._is_factorised = False

    def eliminate(self, b_u: Array, b_c: Array) -> Array:
        """Compute w, and return P^T (A w - b_u)."""
        b_u = b_u + self._lacking
        self._b_contact = b_u[self._contact]
        for copy in self._copies:
            u, b = self._u[copy.rows], copy.turn_back(b_u[copy.rows])
            u[copy.contact] = -copy.turn_back(b_c[copy.held])
            # w = (A_II^-1 (b_I + A_Ic b_c), -b_c)
            u[copy.free] = copy.solve(b[copy.free] - copy.A_Ic @ u[copy.contact])
        return self._B.T @ (self._contact_forces() - self._b_contact)

    def substitute(self, motion: Array) -> tuple[Array, Array]:
        """Return u = w + Z r for the motion r of the parent bodies, and the multipliers."""
        u = np.empty_like(self._u)
        for copy in self._copies:
            self._u[copy.rows] += copy.Z @ copy.turn_back(motion[copy.columns])
            u[copy.rows] = copy.turn(self._u[copy.rows])
        return u, self._contact_forces() - self._b_contact

    def destroy(self) -> None:
        """There is nothing to free."""

    def _contact_forces(self) -> Array:
        """(A_uu u)_c."""
        forces = np.zeros(self._contact.size)
        for copy in self._copies:
            forces[copy.held] = copy.turn(copy.A[copy.contact] @ self._u[copy.rows])
        return forces


class _Copy:
    """A diagonal block of the tangent.

    Args:
        contact: Those of them that couplings hold, counted from the first, shape (k,).
        held: Their numbers among all that couplings hold.

    Attributes:
        Z: In the frame of the factor, shape (rows, columns).
        schur: Its part of the Schur complement there.
        Q: Rotation since the factor was made, shape (3, 3).
    """

    A: Array
    A_Ic: Array
    Z: Array
    schur: Array
    Q: Array

    def __init__(self, rows: slice, columns: slice, contact: IntArray, held: IntArray) -> None:
        self.rows, self.columns, self.held = rows, columns, held
        every = np.arange(rows.stop - rows.start)
        free = np.setdiff1d(every, contact)
        # interfaces come first, and slices copy nothing
        ordered = np.array_equal(contact, every[: len(contact)])
        self.contact: slice | IntArray = slice(0, len(contact)) if ordered else contact
        self.free: slice | IntArray = slice(len(contact), len(every)) if ordered else free

    def factorise(self, A: Array) -> None:
        """Factorise A_II; A must stay as it is as long as the factor serves."""
        self.A, rows = A, A[self.free]
        self.A_Ic = rows[:, self.contact]
        A_II = np.array(rows[:, self.free], order="F")
        self._lu, self._pivots, self._singular = dgetrf(A_II, overwrite_a=True)

    def turn(self, x: Array) -> Array:
        """Vectors of the frame of the factor in space, shape (3 k,)."""
        turned: Array = (x.reshape(-1, 3) @ self.Q.T).ravel()
        return turned

    def turn_back(self, x: Array) -> Array:
        """Vectors of space in the frame of the factor, shape (3 k,)."""
        turned: Array = (x.reshape(-1, 3) @ self.Q).ravel()
        return turned

    def solve(self, b: Array) -> Array:
        """A_II^-1 b, not-a-number if there is no factor, as the next norm shows to all ranks."""
        if self._singular:
            return np.full_like(b, np.nan)
        x, _ = dgetrs(self._lu, self._pivots, b)
        return np.asarray(x)
