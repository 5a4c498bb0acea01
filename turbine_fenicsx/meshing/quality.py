"""Quality, volume and validity of elements of any supported type."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import ReferenceCell

# A scaled Jacobian below this counts as inverted: round-off of a perfectly flat corner is 1e-16,
# the flattest corner of a usable mesh is of the order of 1e-2.
DEGENERATE = 1e-8

# Worse than this is worth a warning: the built-in meshes keep 0.05, see meshes/README.md.
POOR = 0.04

# Cells whose scaled Jacobians differ by less are equally bad, as those of congruent blades are.
# Round-off of edges of a millimetre between coordinates of 100 m is 1e-11.
_TIE = 1e-9

_CHUNK = 4096  # cells examined at once, bounds the memory


@dataclass(frozen=True)
class MeshReport:
    """Size of a mesh and quality of its elements.

    Attributes:
        nodes: Number of nodes.
        cells: Number of cells.
        volumes: Volume of each physical volume by name [m^3].
        worst_quality: Smallest scaled Jacobian of all cells, 1 for a cube or a regular
            tetrahedron, 0 for a degenerate and negative for an inverted cell [-].
        worst_group: Physical volume that holds the worst cell, the first of equally bad ones.
        worst_point: Centre of that cell [m].
        bad_cells: Number of inverted or degenerate cells, those without finite size included.
    """

    cell: str
    geometry_degree: int
    nodes: int
    cells: int
    volumes: dict[str, float]
    worst_quality: float
    worst_group: str
    worst_point: tuple[float, float, float]
    bad_cells: int

    @property
    def mistakes(self) -> list[str]:
        """A sentence if there are inverted cells."""
        if not self.bad_cells:
            return []
        return [
            f"{self.bad_cells} of {self.cells} cells are inverted or degenerate, the worst in "
            f"'{self.worst_group}' at {_place(self.worst_point)}"
        ]

    @property
    def warnings(self) -> list[str]:
        """A sentence if there are poor cells."""
        if self.bad_cells or self.worst_quality >= POOR:
            return []
        return [
            f"the worst cell, in '{self.worst_group}' at {_place(self.worst_point)}, has a scaled "
            f"Jacobian of only {self.worst_quality:.2g}: expected {POOR} or more"
        ]

    def __str__(self) -> str:
        """Return a summary for people, one fact per line."""
        order = {1: "linear", 2: "quadratic"}[self.geometry_degree]
        plural = {"hexahedron": "hexahedra", "tetrahedron": "tetrahedra"}[self.cell]
        point = ", ".join(f"{x:.3f}" for x in self.worst_point)
        return "\n".join(
            [
                f"{self.cells} {order} {plural}, {self.nodes} nodes",
                *(f"volume of {name}: {volume:.4f} m^3" for name, volume in self.volumes.items()),
                f"worst scaled Jacobian {self.worst_quality:.4f} in {self.worst_group} "
                f"at ({point}) m",
            ]
        )


def _place(point: tuple[float, float, float]) -> str:
    """A point in words."""
    return "({:.4g}, {:.4g}, {:.4g}) m".format(*point)


def scaled_jacobian(points: Array, cells: IntArray, reference: ReferenceCell) -> Array:
    """Return the smallest scaled Jacobian of each cell.

    At each sample point it is the volume spanned by three tangent vectors over the product of
    their lengths: 1 if they are perpendicular. For tetrahedra the vectors are those along the
    three edges that meet in a corner, the worst corner counts, and the value is scaled such that
    a regular tetrahedron has 1.

    Args:
        points: Node coordinates, shape (n_points, 3) [m].
        cells: Nodes of each cell in gmsh's order, shape (n_cells, n_nodes).

    Returns:
        Values between -1 and 1, shape (n_cells,) [-].
    """
    worst = [
        np.min(_scale(jacobians, reference.cell), axis=1)
        for jacobians in _jacobians(points, cells, reference, reference.sample_points())
    ]
    return np.concatenate(worst)


def cell_volumes(points: Array, cells: IntArray, reference: ReferenceCell) -> Array:
    """Return the exact volume of each cell, negative if inverted, shape (n_cells,) [m^3].

    The arguments are those of `scaled_jacobian`.
    """
    at, weights = reference.quadrature()
    return np.concatenate(
        [np.linalg.det(j) @ weights for j in _jacobians(points, cells, reference, at)]
    )


def cell_centres(points: Array, cells: IntArray, reference: ReferenceCell) -> Array:
    """Return the centre of gravity of each cell, shape (n_cells, 3) [m].

    The arguments are those of `scaled_jacobian`.
    """
    at, weights = reference.quadrature()
    shapes = reference.shape_functions(at)
    first = 0
    centres = []
    for j in _jacobians(points, cells, reference, at):
        volumes = np.linalg.det(j) * weights
        x = shapes @ points[cells[first : first + len(j)]]
        centres.append(np.einsum("cq,cqi->ci", volumes, x) / volumes.sum(axis=1)[:, None])
        first += len(j)
    return np.concatenate(centres)


def cell_moments(points: Array, cells: IntArray, reference: ReferenceCell) -> Array:
    """Return the integral of x x^T over each cell, shape (n_cells, 3, 3) [m^5].

    The arguments are those of `scaled_jacobian`.
    """
    at, weights = reference.quadrature()
    shapes, first, moments = reference.shape_functions(at), 0, []
    for j in _jacobians(points, cells, reference, at):
        x = shapes @ points[cells[first : first + len(j)]]
        moments.append(np.einsum("cq,cqi,cqj->cij", np.linalg.det(j) * weights, x, x))
        first += len(j)
    return np.concatenate(moments)


def examine(
    points: Array,
    cells: IntArray,
    reference: ReferenceCell,
    groups: dict[str, int],
    cell_groups: IntArray,
) -> MeshReport:
    """Measure a mesh.

    Args:
        points: Node coordinates, shape (n_points, 3) [m].
        cells: Nodes of each cell in gmsh's order, shape (n_cells, n_nodes).
        groups: Number of each physical volume by name.
        cell_groups: Number of the physical volume of each cell, shape (n_cells,).
    """
    with np.errstate(over="ignore", invalid="ignore"):  # such cells count as degenerate
        quality = scaled_jacobian(points, cells, reference)
        volumes = cell_volumes(points, cells, reference)
    worst = int(np.argmax(quality <= quality.min() + _TIE))
    centre = points[cells[worst]].mean(axis=0)
    return MeshReport(
        cell=reference.cell,
        geometry_degree=reference.degree,
        nodes=len(points),
        cells=len(cells),
        volumes={n: float(volumes[cell_groups == tag].sum()) for n, tag in groups.items()},
        worst_quality=float(quality.min()),
        worst_group=next(n for n, tag in groups.items() if tag == cell_groups[worst]),
        worst_point=(float(centre[0]), float(centre[1]), float(centre[2])),
        bad_cells=int(np.count_nonzero(~(quality > DEGENERATE))),
    )


def _jacobians(
    points: Array, cells: IntArray, reference: ReferenceCell, at: Array
) -> Iterator[Array]:
    """Yield dx_i/dxi_j of some cells at a time, shape (n_cells, n_points, 3, 3) [m]."""
    gradients = reference.shape_gradients(at)
    for start in range(0, len(cells), _CHUNK):
        nodes = points[cells[start : start + _CHUNK]]
        yield np.einsum("cni,pnj->cpij", nodes, gradients, optimize=True)


def _scale(jacobians: Array, cell: str) -> Array:
    """Return the scaled Jacobian for each matrix, shape of the argument without the matrix."""
    t1, t2, t3 = (jacobians[..., j] for j in range(3))
    corners = [(t1, t2, t3)]
    unit = 1.0
    if cell == "tetrahedron":
        corners += [(t1, t2 - t1, t3 - t1), (t2, t1 - t2, t3 - t2), (t3, t1 - t3, t2 - t3)]
        unit = np.sqrt(2.0)
    product = np.max(
        [np.prod([np.linalg.norm(t, axis=-1) for t in edges], axis=0) for edges in corners], axis=0
    )
    det = np.linalg.det(jacobians)
    return np.asarray(np.divide(unit * det, product, out=np.zeros_like(det), where=product > 0))
