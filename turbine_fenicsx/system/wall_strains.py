"""Strains at both faces of walls as sums of nodes, for one state or for many.

With the axes a_1, a_2 of the wall at a point, and the functions N_a of the nodes,

    g_i = sum_a (a_i . grad N_a) u_a,      2 E_ij = a_i . g_j + a_j . g_i + g_i . g_j.

The rows of g_i are constant. With u_a = sum_k F_k(X_a) z_k they are dense ones over the vectors of
a reduced body: one product of matrices has the strains of many states.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.wall_quadrature import gauss_quadrature

POINTS = 4
"""Points of a face: two along the span and two around the section."""


@dataclass(frozen=True, eq=False)
class WallStrains:
    """Rows of g_i over k nodes.

    Args:
        rows: Shape (cells 2 POINTS 2, k): faces from the inner to the outer one, points, i.
        axes: a_i there, shape (cells, 2, POINTS, 2, 3).
    """

    rows: Array | csr_matrix
    axes: Array

    @classmethod
    def of(cls, space: Any) -> WallStrains:
        """The rows over the local nodes of a space, ghosts included, for the owned cells.

        Args:
            space: Of the displacement on a mesh with one hexahedron through each wall, whose axes
                are as of `turbine_fenicsx.materials.wall_axes`.
        """
        mesh = space.mesh
        n = mesh.topology.index_map(3).size_local
        points = np.repeat(gauss_quadrature(2, 2, 1).points[None], 2, axis=0)
        points[0, :, 2], points[1, :, 2] = 0.0, 1.0
        nodes, cells = _compat.nodes_of_cells(mesh)[:n], _compat.dofs_of_cells(space)[:n]
        of_mesh, of_space = (
            _differentiate(round(c.shape[1] ** (1 / 3)) - 1, points) for c in (nodes, cells)
        )
        J = np.einsum("fqgj,cgi->cfqji", of_mesh, mesh.geometry.x[nodes])
        # a_1 along J_1, a_2 normal to it in the surface: a_i . grad = sum_j m_ij d/dxi_j
        length = np.linalg.norm(J[..., 0, :], axis=-1)
        a1 = J[..., 0, :] / length[..., None]
        share = np.sum(a1 * J[..., 1, :], axis=-1)
        across = J[..., 1, :] - share[..., None] * a1
        width = np.linalg.norm(across, axis=-1)
        slope, zero = share / (length * width), np.zeros_like(length)
        m = np.stack([np.stack([1.0 / length, zero], -1), np.stack([-slope, 1.0 / width], -1)], -2)
        values = np.einsum("cfqij,fqaj->cfqia", m, of_space)
        columns = np.broadcast_to(cells[:, None, None, None], values.shape)
        ends = np.arange(0, values.size + 1, cells.shape[1])
        index_map = space.dofmap.index_map
        shape = (len(ends) - 1, index_map.size_local + index_map.num_ghosts)
        rows = csr_matrix((values.ravel(), columns.ravel(), ends), shape)
        return cls(rows, np.stack([a1, across / width[..., None]], axis=-2))

    def over(self, functions: Array) -> WallStrains:
        """The rows over vectors whose functions have these values at the nodes, shape (k, n)."""
        return WallStrains(np.ascontiguousarray(self.rows @ functions), self.axes)

    def take(self, cells: IntArray) -> WallStrains:
        """Those of some cells."""
        n = len(self.axes)
        rows = np.arange(self.rows.shape[0]).reshape(n, -1)[cells].ravel()
        return WallStrains(self.rows[rows], self.axes[cells])

    def strains(self, u: Array) -> Array:
        """Strains 11, 22, 12 (engineering) in the axes of the wall.

        Args:
            u: Displacements of the nodes in m states, in the axes of the mesh, shape (k, m, 3).

        Returns:
            Shape (cells, 2, POINTS, m, 3).
        """
        m = u.shape[1]
        g = (self.rows @ u.reshape(len(u), -1)).reshape(*self.axes.shape[:4], m, 3)
        g1, g2 = g[..., 0, :, :], g[..., 1, :, :]
        a1, a2 = self.axes[..., 0, None, :], self.axes[..., 1, None, :]
        found = np.empty_like(g1)
        np.einsum("...i,...i->...", a1 + 0.5 * g1, g1, out=found[..., 0])
        np.einsum("...i,...i->...", a2 + 0.5 * g2, g2, out=found[..., 1])
        np.einsum("...i,...i->...", a1 + g1, g2, out=found[..., 2])
        found[..., 2] += np.einsum("...i,...i->...", a2, g1)
        return found


def _differentiate(degree: int, points: Array) -> Array:
    """Derivatives of shape functions along the first two axes, shape (2, POINTS, nodes, 2)."""
    found = _compat.shape_functions("hexahedron", degree, points.reshape(-1, 3))[1]
    return np.asarray(found[..., :2]).reshape(*points.shape[:2], -1, 2)
