"""Tetrahedra: gmsh fills a solid lofted through the elliptic sections."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.meshing.block import BladeBlock, boundary_faces, split_boundary
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.quality import scaled_jacobian
from turbine_fenicsx.meshing.session import gmsh_session

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


# gmsh's Delaunay mesher is reproducible but leaves a sliver now and then, at a place that depends
# on the surface mesh. So several surface meshers and sizes are tried, until one gives this.
_GOOD_QUALITY = 0.1
_ATTEMPTS = tuple(product((1.0, 0.95, 0.9), (1, 5, 6)))  # size factor, Mesh.Algorithm
_OPTIONS = {
    "Mesh.Algorithm3D": 1,  # Delaunay
    "Mesh.MeshSizeFromPoints": 1,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.Optimize": 1,
    "Mesh.OptimizeThreshold": 0.9,
}


def mesh_blade(blade: BladeGeometry, edge_lengths: list[float], geometry_degree: int) -> BladeBlock:
    """Mesh a blade with tetrahedra.

    The same arguments always give the same mesh, with the same release of gmsh.

    Args:
        blade: Its shape.
        edge_lengths: Target edge length at each station, linear in between [m].
        geometry_degree: 1, or 2 for curved faces on the skin.
    """
    best, best_quality = None, -np.inf
    for factor, algorithm in _ATTEMPTS:
        block = _mesh_linear(blade, [factor * length for length in edge_lengths], algorithm)
        quality = float(scaled_jacobian(block.points, block.cells, block.reference).min())
        if quality > best_quality:
            best, best_quality = block, quality
        if quality >= _GOOD_QUALITY:
            break
    assert best is not None
    return best if geometry_degree == 1 else curve_tetrahedra(best, blade)


def _mesh_linear(blade: BladeGeometry, edge_lengths: list[float], algorithm: int) -> BladeBlock:
    """Mesh the lofted blade with gmsh."""
    reference = reference_cell("tetrahedron", 1)
    with gmsh_session({**_OPTIONS, "Mesh.Algorithm": algorithm}) as gmsh:
        wires = [_draw_section(gmsh, blade, i, length) for i, length in enumerate(edge_lengths)]
        gmsh.model.occ.addThruSections(wires, makeSolid=True, makeRuled=True)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(reference.gmsh_type)
    used, cells = np.unique(nodes, return_inverse=True)
    cells = cells.reshape(-1, 4)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags, used, sorter=order)]
    # gmsh's z axis is the span, its x and y the chord and the thickness
    points = coordinates.reshape(-1, 3)[rows][:, [2, 0, 1]]
    root, skin = split_boundary(points, boundary_faces(cells, reference), blade.hub_radius)
    return BladeBlock(reference, points, cells, root, skin)


def _draw_section(gmsh: Any, blade: BladeGeometry, station: int, edge_length: float) -> int:
    """Draw the ellipse at a station as four arcs and return the tag of its wire.

    The arcs of all sections have the same parametrisation, so that the ruled surface between two
    of them holds the ellipses with linearly interpolated axes exactly.
    """
    occ = gmsh.model.occ
    a, b = blade.chord[station] / 2, blade.thickness[station] / 2
    z = blade.hub_radius + blade.length * blade.stations[station]
    ends = [(a, 0.0), (0.0, b), (-a, 0.0), (0.0, -b)]
    points = [occ.addPoint(x, y, z, edge_length) for x, y in ends]
    centre = occ.addPoint(0.0, 0.0, z)
    long_end = points[0] if a >= b else points[1]
    arcs = [occ.addEllipseArc(points[i], centre, long_end, points[(i + 1) % 4]) for i in range(4)]
    occ.remove([(0, centre)])
    return int(occ.addWire(arcs))
