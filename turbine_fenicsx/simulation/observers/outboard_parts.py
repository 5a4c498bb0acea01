"""Mass, momenta and static moments of the parts of a body that lie beyond sections.

With the masses M_ab of the nodes of the mesh, m_a = sum_b M_ab and the shares w_a of `Cut`,

    p = sum_a w_a (M v)_a,    L = sum_a w_a x_a x (M v)_a,    s = sum_a w_a m_a x_a.

A reduced body moves its nodes by x_a = sum_k F_k(X_a) z_k, so that these are sums over the vectors
z with constant rows:

    p = sum_l b_l z_l',    L = sum_kl B_kl z_k x z_l',    B_kl = sum_ab F_k(X_a) w_a M_ab F_l(X_b).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import cross_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel


class FullParts:
    """Parts of a body on its mesh.

    Args:
        shares: w_a of the owned nodes, shape (n, nodes).
    """

    def __init__(self, model: FlexibleModel, shares: Array) -> None:
        self._model, self._shares = model, shares
        self._weights = shares * model.nodal_mass
        self.masses: Array = sum_over_ranks(model.comm, self._weights.sum(axis=1))
        self._work = model.new_vector(), model.new_vector()

    def sum_up(self, u: Array, v: Array) -> Array:
        """p, L and static moments of this rank, shape (3, n, 3)."""
        rates, momenta = self._work
        rates.array[:] = v.ravel()
        self._model.momentum(rates, momenta)
        x, p = self._model.positions + u, momenta.array_r.reshape(-1, 3)
        return np.array([self._shares @ p, self._shares @ cross_rows(x, p), self._weights @ x])


class ReducedParts:
    """Parts of copies of a reduced body.

    Args:
        copies: Copy of each part.
        shares: w_a of the nodes of the mesh that this rank owns, shape (n, nodes).

    Note:
        Collective.
    """

    def __init__(self, model: ReducedModel, copies: Sequence[int], shares: Array) -> None:
        self._model, self._copies = model, list(copies)
        of_mesh = model.full.mass_matrix()
        starts, columns, values = of_mesh.getValuesCSR()
        of_mesh.destroy()
        F, first = model.mesh_functions, slice(None, None, 3)
        whole = model.functions_at(np.arange(model.full.size_global))
        M = csr_matrix((values, columns, starts), (len(starts) - 1, 3 * len(whole)))[first, first]
        m, MF = M @ np.ones(len(whole)), M @ whole

        def add_up(values: Array) -> Array:
            return sum_over_ranks(model.comm, values)

        self._B = add_up(np.array([F.T @ (w[:, None] * MF) for w in shares]))
        self._b, self._s = add_up(shares @ MF), add_up((shares * m) @ F)
        self.masses: Array = add_up(shares @ m)

    def sum_up(self, u: Array, v: Array) -> Array:
        """p, L and static moments on rank 0, shape (3, n, 3)."""
        found = np.zeros((3, len(self._copies), 3))
        z, rates = self._model.vectors(u.ravel()), self._model.split(v)
        if len(z):
            z, rates = z[self._copies], rates[self._copies]
            found[0] = np.einsum("nk,nki->ni", self._b, rates)
            p = (self._B @ rates).reshape(-1, 3)
            found[1] = cross_rows(z.reshape(-1, 3), p).reshape(z.shape).sum(axis=1)
            found[2] = np.einsum("nk,nki->ni", self._s, z)
        return found
