"""Size of the mesh of a case before it is made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.meshing.topology import count_nodes
from turbine_fenicsx.turbine.case.tower import TowerCase

N_BLADES = 3

PLANE_POINTS = 21
"""Points along each side of the plane on which runs in wind write it."""

_COUNTLESS = 10**18


def size_of_arrays(mesh: MeshArrays, roots: tuple[str, ...], degree: int) -> MeshSize:
    """Count a mesh that exists."""
    tags = [mesh.surfaces[name] for name in roots]
    facets = mesh.facets[np.isin(mesh.facet_groups, tags)]
    return MeshSize(
        mesh.reference.cell,
        len(mesh.cells),
        count_nodes(mesh.cells, mesh.reference, 3, 1),
        count_nodes(mesh.cells, mesh.reference, 3, degree),
        count_nodes(facets, mesh.reference, 2, degree),
    )


def size_of_options(blade: BladeGeometry, options: MeshOptions, degree: int) -> MeshSize:
    """Count or estimate the built-in mesh of three blades."""
    if blade.wall is not None:
        return size_of_hollow(options.span, options.around, ())
    if options.cell == "hexahedron":
        n = options.hexahedra(blade)
        chord, thickness, span = ([p * k + 1 for p in (1, degree)] for k in n)
        return MeshSize(
            options.cell,
            N_BLADES * n[0] * n[1] * n[2],
            N_BLADES * chord[0] * thickness[0] * span[0],
            N_BLADES * chord[1] * thickness[1] * span[1],
            N_BLADES * chord[1] * thickness[1],
            parts=N_BLADES,
            layers=n[2],
        )
    return _count_tetrahedra(blade, options, degree)


def size_of_hollow(n_span: int, n_around: int, webs: Sequence[float]) -> MeshSize:
    """Count the mesh of three hollow blades; with webs it is an estimate, met to 10 %.

    Args:
        n_span: Number of elements along the span.
        n_around: Number of elements around a section.
        webs: Length of each web over that of the blade [-].
    """
    rows = n_span * sum(webs)
    across = max(1.0, n_around / 8.0)
    ring = 2 * n_around * 3
    n_span, plate = n_span + 1, max(n_around // 2 - 2, 0)  # a row and a plate close the tip
    nodes = (
        ring * (2 * n_span + 1)
        + 3 * (2 * plate + 1)
        + (2.0 * across - 1.0) * 3.0 * (2.0 * rows + len(webs))
    )
    corners = 2 * n_around * (n_span + 1) + (across - 1.0) * 2.0 * (rows + len(webs))
    return MeshSize(
        "hexahedron",
        N_BLADES * round(n_span * n_around + plate + across * rows),
        N_BLADES * round(corners),
        N_BLADES * round(nodes),
        N_BLADES * ring,
        not webs,
        N_BLADES,
        n_span,
    )


def size_of_tower(tower: TowerCase) -> MeshSize:
    """Count the mesh of the tower."""
    around, through, along = tower.elements
    p = tower.degree
    ring, nodes_of_ring = (q * around * (q * through + 1) for q in (1, p))
    return MeshSize(
        "hexahedron",
        around * through * along,
        ring * (along + 1),
        nodes_of_ring * (p * along + 1),
        2 * nodes_of_ring,
    )


def _count_tetrahedra(blade: BladeGeometry, options: MeshOptions, degree: int) -> MeshSize:
    """Estimate the numbers of tetrahedra from volume and surface in units of the edge length.

    The coefficients were fitted to meshes of 2000 to 14000 cells per blade, met to 10 %.
    """
    s = (np.arange(2000) + 0.5) / 2000
    h = np.interp(s, blade.stations, options.edge_lengths(blade))
    a, b = blade.chord_at(s) / 2, blade.thickness_at(s) / 2
    perimeter = np.pi * (1.5 * (a + b) - np.sqrt(a * b))
    with np.errstate(all="ignore"):  # absurd shapes have infinitely many
        volume = blade.length * np.mean(np.pi * a * b / h**3)
        surface = blade.length * np.mean(perimeter / h**2)
        layers = blade.length * np.mean(1.0 / h)
        root = max(11.0, 3.0 * np.pi * a[0] * b[0] / h[0] ** 2)
        cells = 3.1 * volume + 1.28 * surface
        vertices = 0.415 * volume + surface
        edges = vertices + cells + 1.2 * surface  # Euler's formula
        counts = (cells, vertices, vertices + (degree - 1) * edges, root * (2 * degree - 1))
    counted = [round(n) if n < _COUNTLESS else _COUNTLESS for n in map(float, (*counts, layers))]
    *whole, along = counted
    n = [N_BLADES * number for number in whole]
    return MeshSize(options.cell, n[0], n[1], n[2], n[3], False, N_BLADES, along)
