"""Second-order tetrahedra whose faces on the skin follow the ellipses of the blade."""

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.meshing.block import BladeBlock, boundary_faces, split_boundary
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.quality import scaled_jacobian

# Ends of the edges that carry the fifth to the tenth node of a tetrahedron, in gmsh's order.
_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]])

# Bending edges may flatten a tetrahedron with two faces on the skin, or turn it inside out. The
# edges of a cell below this quality are straightened step by step until it is met, at last
# completely.
_MIN_QUALITY = 0.05
_RELAXATION = 0.9
_STEPS = 20


def curve_tetrahedra(block: BladeBlock, blade: BladeGeometry) -> BladeBlock:
    """Add a node to each edge and move those on the skin to the ellipse of their section.

    Args:
        blade: Shape of the blade.

    Returns:
        Second-order tetrahedra. No cell is worse than ``_MIN_QUALITY`` unless its straight-sided
        version is.
    """
    reference = reference_cell("tetrahedron", 2)
    ends = np.sort(block.cells[:, _EDGES], axis=2)
    edges, number = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    number = number.reshape(-1, 6)
    cells = np.hstack([block.cells, len(block.points) + number])
    straight = block.points[edges].mean(axis=1)
    offset = _offset_to_skin(straight, blade)
    offset[~_is_lateral(edges, block, blade)] = 0.0

    curvature = np.ones(len(edges))
    for step in range(_STEPS + 1):
        points = np.vstack([block.points, straight + curvature[:, None] * offset])
        bad = scaled_jacobian(points, cells, reference) < _MIN_QUALITY
        if not np.any(curvature[number[bad]] > 0):
            break
        curvature[np.unique(number[bad])] *= _RELAXATION if step < _STEPS - 1 else 0.0
    root, skin = split_boundary(points, boundary_faces(cells, reference), blade.hub_radius)
    return BladeBlock(reference, points, cells, root, skin)


def _offset_to_skin(points: Array, blade: BladeGeometry) -> Array:
    """Return the radial vector from each point to the ellipse of its section [m]."""
    fraction = (points[:, 0] - blade.hub_radius) / blade.length
    axes = np.stack([blade.chord_at(fraction), blade.thickness_at(fraction)], axis=1) / 2
    radius = np.linalg.norm(points[:, 1:] / axes, axis=1, keepdims=True)
    offset = np.zeros_like(points)
    offset[:, 1:] = points[:, 1:] * (1 / np.maximum(radius, 0.1) - 1)
    return offset


def _is_lateral(edges: IntArray, block: BladeBlock, blade: BladeGeometry) -> npt.NDArray[np.bool_]:
    """Find edges that belong to a face of the skin other than the tip, shape (n_edges,)."""
    tip = blade.hub_radius + blade.length
    at_tip = np.abs(block.points[:, 0] - tip) <= 1e-9 * tip
    lateral = block.skin[~at_tip[block.skin].all(axis=1)]
    pairs = np.sort(lateral[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    n = len(block.points)
    return np.isin(edges @ [n, 1], pairs @ [n, 1])
