"""Reference elements in gmsh's node order: shape functions, quadrature, faces.

Every element is described by the positions of its nodes on the unit cube or unit simplex; the
shape functions follow from these by inverting a small matrix of monomials.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import sqrt

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray

_HEXAHEDRON = [
    [0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2],
    [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 1, 0], [2, 0, 1], [1, 2, 0], [2, 2, 1], [0, 2, 1],
    [1, 0, 2], [0, 1, 2], [2, 1, 2], [1, 2, 2],
    [1, 1, 0], [1, 0, 1], [0, 1, 1], [2, 1, 1], [1, 2, 1], [1, 1, 2],
    [1, 1, 1],
]  # fmt: skip
_TETRAHEDRON = [
    [0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2],
    [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 0, 1],
]  # fmt: skip
_CORNERS = {"hexahedron": 8, "tetrahedron": 4}
# Corners of each face, listed anticlockwise as seen from outside.
_FACES = {
    "hexahedron": [
        [0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [0, 4, 7, 3], [1, 2, 6, 5],
    ],
    "tetrahedron": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}  # fmt: skip


@dataclass(frozen=True)
class ReferenceCell:
    """A hexahedron or tetrahedron of first or second order.

    Attributes:
        gmsh_type: gmsh's number of the element type.
        gmsh_facet_type: gmsh's number of the type of its faces.
    """

    cell: str
    degree: int
    gmsh_type: int
    gmsh_facet_type: int

    @property
    def facet(self) -> str:
        """Cell type of the faces, "quadrilateral" or "triangle"."""
        return "quadrilateral" if self.cell == "hexahedron" else "triangle"

    @property
    def lattice(self) -> IntArray:
        """Node positions times the degree, as whole numbers, shape (n_nodes, 3)."""
        table = np.array(_HEXAHEDRON if self.cell == "hexahedron" else _TETRAHEDRON)
        return table if self.degree == 2 else table[: _CORNERS[self.cell]] // 2

    @property
    def nodes(self) -> Array:
        """Node positions on the unit cube or simplex, shape (n_nodes, 3)."""
        return self.lattice / self.degree

    @property
    def faces(self) -> IntArray:
        """Local nodes of each face in gmsh's order, outward normal, shape (n_faces, n)."""
        corners = _FACES[self.cell]
        if self.degree == 1:
            return np.array(corners)
        number = {tuple(position): i for i, position in enumerate(self.lattice)}
        faces = []
        for face in corners:
            ends = [
                self.lattice[a] + self.lattice[b]
                for a, b in zip(face, face[1:] + face[:1], strict=True)
            ]
            nodes = face + [number[tuple(end // 2)] for end in ends]
            if len(face) == 4:
                nodes.append(number[tuple(sum(self.lattice[a] for a in face) // 4)])
            faces.append(nodes)
        return np.array(faces)

    @cached_property
    def _exponents(self) -> IntArray:
        """Exponents of the monomials that span the shape functions, shape (n_nodes, 3)."""
        powers = product(range(self.degree + 1), repeat=3)
        full = self.cell == "hexahedron"
        return np.array([e for e in powers if full or sum(e) <= self.degree])

    @cached_property
    def _coefficients(self) -> Array:
        """Coefficients of the shape functions in the monomials, shape (n_nodes, n_nodes)."""
        monomials = np.prod(self.nodes[:, None, :] ** self._exponents, axis=2)
        return np.asarray(np.linalg.inv(monomials))

    def shape_functions(self, points: Array) -> Array:
        """Return the shape functions at points of the reference element, (n_points, n_nodes)."""
        monomials = np.prod(points[:, None, :] ** self._exponents, axis=2)
        return np.asarray(monomials @ self._coefficients)

    def shape_gradients(self, points: Array) -> Array:
        """Return the gradients of the shape functions.

        Args:
            points: Points of the reference element, shape (n_points, 3).

        Returns:
            Derivatives by the reference coordinates, shape (n_points, n_nodes, 3).
        """
        columns = []
        for axis in range(3):
            lowered = self._exponents.copy()
            lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
            monomials = np.prod(points[:, None, :] ** lowered, axis=2)
            columns.append((monomials * self._exponents[:, axis]) @ self._coefficients)
        return np.stack(columns, axis=2)

    def quadrature(self) -> tuple[Array, Array]:
        """Return points, shape (n, 3), and weights, shape (n,), exact for the volume."""
        gauss, w = sqrt(0.15), np.array([5.0, 8.0, 5.0]) / 18.0
        x = 0.5 + np.array([-gauss, 0.0, gauss])
        r, s, t = (grid.ravel() for grid in np.meshgrid(x, x, x, indexing="ij"))
        weights = np.einsum("i,j,k->ijk", w, w, w).ravel()
        if self.cell == "hexahedron":
            return np.stack([r, s, t], axis=1), weights
        # the cube collapsed to the simplex; the Jacobian of the collapse joins the weights
        points = np.stack([r, s * (1 - r), t * (1 - r) * (1 - s)], axis=1)
        return points, weights * (1 - r) ** 2 * (1 - s)

    def sample_points(self) -> Array:
        """Return the points at which an element is examined: nodes, Gauss points and a lattice.

        A first-order tetrahedron has the same Jacobian everywhere and needs one point. The others
        get at least as many points along an edge as fix the polynomial that the Jacobian is there.
        """
        if self.cell == "tetrahedron" and self.degree == 1:
            return np.full((1, 3), 0.25)
        n = {1: 2, 2: 5}[self.degree]
        lattice = np.array(list(product(range(n + 1), repeat=3))) / n
        if self.cell == "tetrahedron":
            lattice = lattice[lattice.sum(axis=1) <= 1 + 1e-12]
        points = np.concatenate([self.nodes, lattice, self.quadrature()[0]])
        different: Array = np.unique(points, axis=0)
        return different


REFERENCE_CELLS = (
    ReferenceCell("tetrahedron", 1, 4, 2),
    ReferenceCell("hexahedron", 1, 5, 3),
    ReferenceCell("tetrahedron", 2, 11, 9),
    ReferenceCell("hexahedron", 2, 12, 10),
)


def reference_cell(cell: str, degree: int) -> ReferenceCell:
    """Return the reference element with this name and degree."""
    return next(r for r in REFERENCE_CELLS if (r.cell, r.degree) == (cell, degree))
