"""Local rotations of a flexible body: the frames in which its stiffness hardly changes."""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.flexible_model import FlexibleModel


class NodeFrames:
    """Rotation R of the material around each node, from the polar decomposition F = R U.

    F in a cell is the mean over its volume; at a node it is the mean of its cells. The rotations
    follow bending and twist along a slender body, not only its motion as a whole. (The affine map
    nearest to the nodes of a cell would do as well in solids, but not in thin curved walls. There
    nodes differ along the normal mainly by curvature, and smooth motions look like strain.)
    """

    def __init__(self, flexible: FlexibleModel) -> None:
        """Compute the mean gradients of the shape functions."""
        self._flexible = flexible
        n_cells = flexible.body.mesh.topology.index_map(3).size_local
        n_nodes = len(flexible.local_positions)
        self._cells = _compat.dofs_of_cells(flexible.space)[:n_cells]
        X = flexible.local_positions[self._cells]
        cell, degree = _compat.cell_name(flexible.body.mesh), flexible.body.degree
        self._weights = mean_gradients(X, cell, degree)
        # Row a, column c: 1 if node a belongs to cell c.
        owners = np.repeat(np.arange(n_cells), self._cells.shape[1])
        entries = np.ones(owners.size), (self._cells.ravel(), owners)
        self._cells_of_nodes = csr_matrix(entries, shape=(n_nodes, n_cells))
        counts = np.repeat(np.diff(self._cells_of_nodes.indptr)[:, None].astype(float), 3, axis=1)
        self._count = flexible.sum_at_owners(counts)[:, 0]

    def rotations(
        self, u: PETSc.Vec, du: PETSc.Vec | None = None, parts: tuple[float, ...] = (0.0,)
    ) -> list[Array]:
        """Rotations at the owned nodes. Collective.

        Args:
            u: Displacements [m].
            du: Increments of which parts are added, if given.

        Returns:
            For each part R, shape (3, 3, n_owned), the node last so that products run over long
            rows.
        """
        F, *dF = self._gradients([u] if du is None else [u, du])
        F[::4] += 1.0
        F = np.concatenate([F + sum(part * D for D in dF) for part in parts], axis=1)
        R = polar_rotation(F.reshape(3, 3, -1), tolerance=1e-10)
        return np.split(R, len(parts), axis=2)

    def _gradients(self, displacements: Sequence[PETSc.Vec]) -> Array:
        """Mean gradients of displacements around each owned node, shape (fields, 9, n_owned)."""
        x = np.hstack([self._flexible.nodal_values(u) for u in displacements])
        of_cells = x[self._cells].swapaxes(1, 2) @ self._weights
        total = self._cells_of_nodes @ of_cells.reshape(len(of_cells), 3 * x.shape[1])
        parts = np.split(total, x.shape[1], axis=1)
        mean = np.hstack([self._flexible.sum_at_owners(part) for part in parts])
        mean = np.ascontiguousarray((mean / self._count[:, None]).T)  # the rest runs along nodes
        return mean.reshape(len(displacements), 9, mean.shape[1])


def mean_gradients(X: Array, cell: str, degree: int) -> Array:
    """Gradients of the shape functions of Lagrange cells, means over the volume of each.

    With the Jacobian J = dX/dxi and its cofactors cof J = det(J) J^-T, all polynomials,

        int grad N_a dV = int cof(J) dN_a/dxi dxi,    V = int det(J) dxi.

    Args:
        X: Positions of the nodes, in the order of DOLFINx, shape (n_cells, nodes, 3) [m].
        degree: Of the shape functions.

    Returns:
        Shape (n_cells, nodes, 3) [1/m].
    """
    # det(J) has degree 3 p - 1 in each direction of a hexahedron, 3 p - 3 altogether in others
    points, factors = _compat.quadrature(cell, 3 * degree - 1)
    derivatives = _compat.shape_functions(cell, degree, points)[1]
    total, volume = np.zeros(X.shape), np.zeros(len(X))
    for factor, D in zip(factors, derivatives, strict=True):
        J = np.swapaxes(X, 1, 2) @ D
        a, b, c = J[:, :, 0], J[:, :, 1], J[:, :, 2]
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        total += factor * (D @ cofactors)
        volume += factor * np.einsum("ni,ni->n", a, cofactors[:, 0])
    return total / volume[:, None, None]


def polar_rotation(F: Array, tolerance: float = 1e-16) -> Array:
    """Orthogonal factor of F = R U by Newton-Schulz iteration, for many F together.

    Args:
        F: Shape (3, 3, n), not far from orthogonal.
        tolerance: Accuracy of R. Each iteration squares the error; after five it is round-off for
            stretches of up to a quarter, and no more are made.

    Returns:
        R, shape (3, 3, n).
    """
    R: Array = F * np.sqrt(3.0 / np.sum(F * F, axis=(0, 1)))
    one = np.eye(3)[:, :, None]
    for _ in range(5):
        # R <- R - R E/2 with E = R^T R - 1, row by row along the nodes, faster than einsum
        E = R[0][:, None] * R[0]
        E += R[1][:, None] * R[1]
        E += R[2][:, None] * R[2]
        E -= one
        error = max(float(np.max(E, initial=0.0)), -float(np.min(E, initial=0.0)))
        change = R[:, 0, None] * E[0]
        change += R[:, 1, None] * E[1]
        change += R[:, 2, None] * E[2]
        R = R - 0.5 * change
        if error**2 < tolerance:
            break
    return R


def turn(R: Array, v: Array, inverse: bool = False) -> Array:
    """Nodewise products R v, or R^T v.

    Args:
        R: Shape (3, 3, n).
        v: One or several vectors, shape (..., 3 n), node by node.

    Returns:
        Shape (..., 3 n).
    """
    by_node = v.reshape(*v.shape[:-1], -1, 3)
    x = np.ascontiguousarray(by_node.swapaxes(-1, -2))  # rows of n numbers for einsum
    turned: Array = np.einsum("jin,...jn->...in" if inverse else "ijn,...jn->...in", R, x)
    return turned.swapaxes(-1, -2).reshape(v.shape)
