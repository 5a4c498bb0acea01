"""Local rotations of a flexible body: the frames in which its stiffness hardly changes."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.rotations import Array


class NodeFrames:
    """Rotation R of the material around each node, from the polar decomposition F = R U.

    F in a cell is the best affine map of its nodes; at a node it is the mean of its cells. The
    rotations follow bending and twist along a slender body, not only its motion as a whole.

    Args:
        flexible: The flexible body.
    """

    def __init__(self, flexible: FlexibleBlock) -> None:
        """Compute the weights of the best affine maps."""
        self._flexible = flexible
        n_cells = flexible.body.mesh.topology.index_map(3).size_local
        self._cells = _compat.dofs_of_cells(flexible.space)[:n_cells]
        X = flexible.local_positions[self._cells]
        X = X - X.mean(axis=1, keepdims=True)
        self._weights = X @ np.linalg.inv(np.swapaxes(X, 1, 2) @ X)
        self._n_local = len(flexible.local_positions)
        ones = np.bincount(self._cells.ravel(), minlength=self._n_local).astype(float)
        self._count = flexible.sum_at_owners(np.repeat(ones[:, None], 3, axis=1))[:, 0]

    def rotations(self, u: Array) -> Array:
        """Rotations at the owned nodes.

        Args:
            u: Displacements of all local nodes, ghosts included, shape (nodes, 3) [m].

        Returns:
            R, shape (3, 3, n_owned), the node last so that products run over long rows.

        Note:
            Collective.
        """
        n_nodes = self._cells.shape[1]
        grad_u = np.swapaxes(u[self._cells], 1, 2) @ self._weights
        F = np.empty((3, 3, self._flexible.n_owned))
        for j in range(3):
            column = np.column_stack(
                [
                    np.bincount(
                        self._cells.ravel(),
                        np.repeat(grad_u[:, i, j], n_nodes),
                        minlength=self._n_local,
                    ).astype(float)
                    for i in range(3)
                ]
            )
            F[:, j] = self._flexible.sum_at_owners(column).T / self._count
            F[j, j] += 1.0
        return polar_rotation(F)


def polar_rotation(F: Array, iterations: int = 5) -> Array:
    """Orthogonal factor of F = R U by Newton-Schulz iteration, for many F at once.

    Args:
        F: Shape (3, 3, n), not far from orthogonal.
        iterations: Each squares the error; five give round-off for stretches of up to a quarter.

    Returns:
        R, shape (3, 3, n). It need only be near for a preconditioner.
    """
    R = F * np.sqrt(3.0 / np.sum(F * F, axis=(0, 1)))
    for _ in range(iterations):
        C = np.einsum("kin,kjn->ijn", R, R)
        R = 1.5 * R - 0.5 * np.einsum("ikn,kjn->ijn", R, C)
    return R


def turn(R: Array, v: Array, inverse: bool = False) -> Array:
    """Nodewise products R v, or R^T v.

    Args:
        R: Shape (3, 3, n).
        v: Shape (3 n,), node by node.
        inverse: Whether to multiply by the transpose.

    Returns:
        Shape (3 n,).
    """
    x = v.reshape(-1, 3)
    out = np.empty_like(x)
    for i in range(3):
        a = R[:, i] if inverse else R[i]
        out[:, i] = a[0] * x[:, 0] + a[1] * x[:, 1] + a[2] * x[:, 2]
    return out.ravel()
