"""Components of a mesh that a rigid motion takes to one another, such as the blades of a rotor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx.foundation.types import Array

Indices = npt.NDArray[np.int64]

SAME_PLACE = 1e-6
"""Largest distance of two nodes that are one after a rigid motion, as a part of the component."""

CONGRUENCE_TOLERANCE = 1e-4
"""Largest difference of two stiffnesses that share a factor, as a part of their diagonals. It costs
no accuracy, only iterations: for hollow blades bent by their weight, with differences of 1.4e-3,
three per step instead of two, with 2e-2 eighteen instead of five."""

SAMPLES = 3
"""Number of random motions of all nodes that distinguish two stiffnesses."""

MOST_MOTIONS = 24
"""Maximum number of rigid motions that are tried; as many take a cube to itself."""


@dataclass(frozen=True)
class Copy:
    """A component that is congruent to the first one of its group.

    Args:
        nodes: Its nodes in the order of those of the first, shape (n,).
        rotation: Rotations T of the nodes, shape (3, 3, n): its stiffness is T A T^T with A that
            of the first.
        motion: Rotation Q of the motion that takes the first to this one, shape (3, 3).
    """

    nodes: Indices
    rotation: Array
    motion: Array

    def relative_to(self, other: Copy) -> Copy:
        """The same with another one as the first."""
        T = np.einsum("ian,jan->ijn", self.rotation, other.rotation)
        return Copy(self.nodes, T, self.motion @ other.motion.T)


def label_components(starts: npt.NDArray[Any], columns: npt.NDArray[Any]) -> Indices:
    """The connected component of each node, counted from zero, shape (nodes,).

    Args:
        starts: Where each row of a symmetric matrix starts, of which each node has three.
        columns: Columns of its entries, the same for the rows of a node.
    """
    n = starts.size - 1
    pattern = csr_matrix((np.ones(columns.size, dtype=np.int8), columns, starts), (n, n))
    labels: Indices = connected_components(pattern[::3, ::3], directed=False)[1]
    return labels


def find_groups(matrix: Any, positions: Array, rotations: Array) -> list[list[Copy]]:
    """Connected components of a stiffness, those with the same stiffness in one group.

    Let X' = Q X + t be a rigid motion that takes the nodes of a component to those of another one,
    and R the rotation of the material around each node since then. If nothing but their position
    distinguishes them,

        A' = T A T^T,    T = R' Q R^T  at each node,

    and that is what decides: whatever may differ, thickness, material, strain, is in the matrix. It
    is compared by the forces of random motions V of all nodes, A' T V with T A V.

    Args:
        matrix: Symmetric, three rows for each node, as csr_matrix.
        positions: Initial positions of the nodes, shape (n, 3) [m].
        rotations: R of the nodes, shape (3, 3, n).

    Returns:
        The components in the order of their first nodes, in groups.
    """
    component = label_components(matrix.indptr, matrix.indices)
    by_component = np.argsort(component, kind="stable")
    # sizes of the diagonal, which scale motions and forces to the same order at all nodes
    sizes = np.sqrt(np.abs(matrix.diagonal()).reshape(-1, 3).sum(axis=1))
    groups: list[list[Copy]] = []
    for nodes in np.split(by_component, np.cumsum(np.bincount(component))[:-1]):
        for group in groups:
            copy = _find_copy(matrix, positions, rotations, sizes, group[0].nodes, nodes)
            if copy is not None:
                group.append(copy)
                break
        else:
            unit = np.repeat(np.eye(3)[:, :, None], len(nodes), axis=2)
            groups.append([Copy(nodes, unit, np.eye(3))])
    return groups


def _find_copy(
    matrix: Any, positions: Array, rotations: Array, sizes: Array, first: Indices, nodes: Indices
) -> Copy | None:
    """The component of some nodes as a copy of the first of a group, None if it is not."""
    if len(nodes) != len(first):
        return None
    signs = np.random.default_rng(0).choice((-1.0, 1.0), size=(len(first), 3, SAMPLES))
    scale = sizes[first, None, None]

    def forces(at: Indices, V: Array) -> Array:
        """Forces of motions of the nodes of a component, shapes (n, 3, samples), scaled."""
        moved = np.zeros((len(positions), 3, SAMPLES))
        moved[at] = V / scale
        product = matrix @ moved.reshape(-1, SAMPLES)
        return np.asarray(product.reshape(moved.shape)[at] / scale)

    expected = None
    for order, Q in _find_motions(positions[first], positions[nodes]):
        copy = nodes[order]
        T = np.einsum("ian,ab,jbn->ijn", rotations[:, :, copy], Q, rotations[:, :, first])
        if expected is None:
            expected = forces(first, signs)
        found = forces(copy, np.einsum("ijn,njk->nik", T, signs))
        if np.max(np.abs(found - np.einsum("ijn,njk->nik", T, expected))) <= CONGRUENCE_TOLERANCE:
            return Copy(copy, T, Q)
    return None


def _find_motions(X: Array, Y: Array) -> Iterator[tuple[Indices, Array]]:
    """Rigid motions from points X to points Y, both of shape (n, 3).

    A motion is known from where the centre and two more points go: the one farthest from the
    centre, and the one farthest from the line through both. They go to points at the same
    distances.

    Yields:
        The number of the point of Y that each of X goes to, and Q.
    """
    from scipy.spatial import cKDTree

    x, y = X - X.mean(axis=0), Y - Y.mean(axis=0)
    r, s = np.linalg.norm(x, axis=1), np.linalg.norm(y, axis=1)
    a = int(np.argmax(r))
    near = SAME_PLACE * r[a]
    off_axis = np.linalg.norm(np.cross(x[a], x), axis=1)
    b = int(np.argmax(off_axis))
    if off_axis[b] <= near * r[a]:  # a line, or a single node
        return
    axes, tree, tried = _find_axes(x[a], x[b]), cKDTree(y), 0
    for i in np.flatnonzero(np.abs(s - r[a]) < near):
        apart = np.linalg.norm(y - y[i], axis=1) - np.linalg.norm(x[b] - x[a])
        for j in np.flatnonzero((np.abs(s - r[b]) < near) & (np.abs(apart) < near)):
            Q = _find_axes(y[i], y[j]) @ axes.T
            distance, order = tree.query(x @ Q.T, distance_upper_bound=near)
            if np.all(np.isfinite(distance)) and len(np.unique(order)) == len(order):
                tried += 1
                yield order, Q
                if tried == MOST_MOTIONS:
                    return


def _find_axes(a: Array, b: Array) -> Array:
    """Right-handed unit vectors along a, across it towards b, and across both; columns."""
    first = a / np.linalg.norm(a)
    third = np.cross(first, b)
    third /= np.linalg.norm(third)
    return np.column_stack([first, np.cross(third, first), third])
