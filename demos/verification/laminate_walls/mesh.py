"""Structured meshes of walls: one quadratic hexahedron through the thickness."""

import numpy as np

from turbine_fenicsx.meshing.block import boundary_faces
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.load import load_arrays
from turbine_fenicsx.meshing.model import MeshArrays

HEXAHEDRON = reference_cell("hexahedron", 2)


def wall_arrays(place, span, around, closed=False):
    """Cells with reference axes along span, around and outwards, each in a volume of its own.

    Args:
        place: Points of arrays s, a from 0 to 1 and zeta from -1/2 to 1/2, one axis more.
        span: Number of cells along s, or the fractions s of their faces.
        around: Number of cells along a.
        closed: Whether a = 1 is a = 0.
    """
    s = np.linspace(0, 1, span + 1) if np.ndim(span) == 0 else np.asarray(span)
    s = np.interp(np.arange(2 * len(s) - 1) / 2, np.arange(len(s)), s)
    n_s, n_a = len(s) // 2, around
    a, zeta = np.linspace(0, 1, 2 * n_a + 1), np.linspace(-0.5, 0.5, 3)
    if closed:
        a = a[:-1]
    points = place(*np.meshgrid(s, a, zeta, indexing="ij"))
    number = np.arange(points[..., 0].size).reshape(points.shape[:3])
    i, j, k = HEXAHEDRON.lattice.T
    m, n = (grid.reshape(-1, 1) for grid in np.meshgrid(range(n_s), range(n_a), indexing="ij"))
    cells = number[2 * m + i, (2 * n + j) % len(a), k]
    facets = boundary_faces(cells, HEXAHEDRON)
    ends = [np.isin(facets, number[end]).all(axis=1) for end in (0, -1)]
    groups = np.select(ends, [1, 2], 3)
    return MeshArrays(
        HEXAHEDRON,
        points.reshape(-1, 3),
        cells,
        np.arange(1, len(cells) + 1),
        facets,
        groups,
        {f"cell_{c}": c + 1 for c in range(len(cells))},
        {name: g for g, name in enumerate(("root", "tip", "side"), 1) if np.any(groups == g)},
    )


def load_wall(comm, arrays):
    """The mesh, and the number in the arrays of each cell that this rank owns."""
    loaded = load_arrays(comm, lambda: arrays, "wall")
    tags = loaded.cell_tags
    number = np.empty(loaded.mesh.topology.index_map(3).size_local, dtype=int)
    owned = tags.indices < len(number)
    number[tags.indices[owned]] = tags.values[owned] - 1
    return loaded, number


def flat_strip(length, width, thickness, span, around):
    """A strip in the plane of x and y, its middle on the x axis."""

    def place(s, a, z):
        return np.stack([length * s, width * (a - 0.5), thickness * z], axis=-1)

    return wall_arrays(place, span, around)


def round_tube(radius, thickness, length, span, around):
    """A tube along x; radius and thickness in the middle of the wall as functions of s."""

    def place(s, a, z):
        r, angle = radius(s) + thickness(s) * z, 2 * np.pi * a
        return np.stack([length * s, r * np.sin(angle), r * np.cos(angle)], axis=-1)

    return wall_arrays(place, span, around, closed=True)
