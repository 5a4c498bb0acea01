"""Topology of a mesh by sorting: faces between cells, connected parts, coincident nodes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.block import face_keys
from turbine_fenicsx.meshing.cells import ReferenceCell

_EDGES = {
    ("hexahedron", 3): [
        (0, 1), (1, 2), (2, 3), (0, 3), (4, 5), (5, 6), (6, 7), (4, 7), (0, 4), (1, 5), (2, 6),
        (3, 7),
    ],
    ("hexahedron", 2): [(0, 1), (1, 2), (2, 3), (0, 3)],
    ("tetrahedron", 3): list(combinations(range(4), 2)),
    ("tetrahedron", 2): list(combinations(range(3), 2)),
}  # fmt: skip
"""Corners of the edges of a cell (3) and of its faces (2)."""


@dataclass(frozen=True)
class Faces:
    """All faces of all cells, in the order of their keys.

    Attributes:
        keys: Key of each face, shape (n_cells faces per cell,), sorted.
        cells: The cell of each, same shape.
        first: Where each different face begins, shape (n_different,).
        counts: Number of cells at each different face, shape (n_different,).
    """

    keys: npt.NDArray[np.uint64]
    cells: IntArray
    first: IntArray
    counts: IntArray

    @property
    def neighbours(self) -> IntArray:
        """Pairs of cells with a common face, shape (n, 2)."""
        first = self.first[self.counts == 2]
        return np.stack([self.cells[first], self.cells[first + 1]], axis=1)

    def find(self, keys: npt.NDArray[np.uint64]) -> tuple[IntArray, IntArray]:
        """Return one cell at each face, and the number of its cells, shapes of the keys."""
        place = np.searchsorted(self.keys[self.first], keys)
        return self.cells[self.first[place]], self.counts[place]


def faces_of(cells: IntArray, reference: ReferenceCell) -> Faces:
    """Return the faces of cells given by their nodes, shape (n_cells, n)."""
    faces = cells[:, reference.faces]
    keys = face_keys(faces.reshape(-1, faces.shape[2]), reference)
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    return Faces(keys[order], order // faces.shape[1], first, counts)


def number_connected_parts(n: int, pairs: IntArray) -> IntArray:
    """Return the number of the connected part of each thing.

    Each root of a growing forest hangs itself below a smaller neighbour, then all paths are
    shortened, until neighbours have the same root; some log n rounds.

    Args:
        n: Number of things.
        pairs: Things that hang together, shape (m, 2).

    Returns:
        The smallest thing of its part, shape (n,).
    """
    root = np.arange(n)
    while True:
        a, b = root[pairs[:, 0]], root[pairs[:, 1]]
        apart = a != b
        if not apart.any():
            return root
        pairs, a, b = pairs[apart], a[apart], b[apart]
        root[np.maximum(a, b)] = np.minimum(a, b)
        while (root[root] != root).any():
            root = root[root]


def count_coincident_nodes(points: Array, tolerance: float) -> int:
    """Return how many nodes lie on top of others.

    Args:
        points: Coordinates, shape (n, 3) [m].
        tolerance: Distance below which two nodes are one [m].
    """
    # along a direction that has nothing to do with the mesh, such nodes come one after another
    order = np.argsort(points @ np.array([0.5377, 0.2718, 0.7981]), kind="stable")
    distance = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    return int(np.count_nonzero(distance <= tolerance))


def count_nodes(elements: IntArray, reference: ReferenceCell, dimension: int, degree: int) -> int:
    """Return the number of nodes of a Lagrange space.

    Args:
        elements: Nodes of each cell, or of each face, in gmsh's order, shape (n, m).
    """
    hexahedral = reference.cell == "hexahedron"
    n_corners = {(True, 3): 8, (True, 2): 4, (False, 3): 4, (False, 2): 3}[hexahedral, dimension]
    corners = elements[:, :n_corners]
    count = len(np.unique(corners))
    if degree == 1:
        return count
    ends = np.sort(corners[:, _EDGES[reference.cell, dimension]].reshape(-1, 2), axis=1)
    count += len(np.unique(ends[:, 0] * (corners.max(initial=0) + 1) + ends[:, 1]))
    if hexahedral:
        count += len(elements)
        count += len(faces_of(elements, reference).first) if dimension == 3 else 0
    return count
