"""Tetrahedra: gmsh fills a solid lofted through the elliptic sections."""

from itertools import product
from typing import Any

import numpy as np

from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.meshing.block import BladeBlock, boundary_faces, split_boundary
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.curving import curve_tetrahedra
from turbine_fenicsx.meshing.quality import scaled_jacobian
from turbine_fenicsx.meshing.session import gmsh_session

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
