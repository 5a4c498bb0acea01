"""Cross-sections of the solid mesh, integrated with the moduli of its laminates."""

import numpy as np

from turbine_fenicsx.materials.laminate_theory import mass_per_area, tabulate_walls

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def section(solid, beam, s):
    """Mass, stretch and bending stiffness of the section at a fraction of the span.

    Args:
        solid: A `solid.Solid`.
        beam: The same blade as a `exact.Blade`, whose section axes are taken.
        s: The fraction.

    Returns:
        Mass per length [kg/m], EA [N], and EI [N m^2] edgewise and flapwise.
    """
    block = solid.block
    first, last = block.span.T
    cells = np.flatnonzero((first <= s) & (s < last))
    t = 2.0 * (s - first[cells]) / (last[cells] - first[cells]) - 1.0
    lattice = np.empty((len(cells), 3, 3, 3, 3))
    i, j, k = block.reference.lattice.T
    lattice[:, i, j, k] = block.points[block.cells[cells]]
    across = np.einsum("ci,cijkx->cjkx", _shapes(t), lattice)
    N, dN = _shapes(_GAUSS), _slopes(_GAUSS)
    x = np.einsum("pj,qk,cjkx->cpqx", N, N, across)
    a, b = (np.einsum("pj,qk,cjkx->cpqx", *pair, across) for pair in ((dN, N), (N, dN)))
    origin, e_x, e_y, e_z = _axes(solid.blade, beam, s)
    dA = np.abs(np.cross(a, b) @ e_z) * _WEIGHTS[:, None] * _WEIGHTS
    x_s, y_s = (x - origin) @ e_x, (x - origin) @ e_y
    table = tabulate_walls([solid.laminates[c] for c in cells], block.thickness[cells])
    Q = table.in_plane[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    E = 1.0 / np.linalg.inv(Q)[:, 0, 0, None, None]  # no stress around the section
    mass, EA = np.sum(table.density[:, None, None] * dA), np.sum(E * dA)
    x_c, y_c = np.sum(E * x_s * dA) / EA, np.sum(E * y_s * dA) / EA
    return mass, EA, np.sum(E * (y_s - y_c) ** 2 * dA), np.sum(E * (x_s - x_c) ** 2 * dA)


def published_section(beam, s):
    """The same of the file's matrices."""
    own = beam.sections
    K, M = (
        np.apply_along_axis(lambda v: np.interp(s, own.grid, v), 0, values)
        for values in (own.stiffness, own.inertia)
    )
    EA = K[2, 2]
    return M[0, 0], EA, K[3, 3] - K[2, 3] ** 2 / EA, K[4, 4] - K[2, 4] ** 2 / EA


def _axes(blade, beam, s):
    """Origin, x, y and z of a section in the axes of the mesh."""
    (point,), turn = beam.frames(np.array([s]))
    rows = turn[0].T
    to_file = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    hub = np.array([blade.hub_radius, 0.0, 0.0])
    return point @ to_file + hub, *(rows @ to_file)


def _shapes(t):
    """Quadratic shape functions on [-1, 1], shape (points, 3)."""
    return np.stack([0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)], axis=1)


def _slopes(t):
    return np.stack([t - 0.5, -2.0 * t, t + 0.5], axis=1)


def mass_of_cells(solid):
    """Mass of the laminates of all cells on the outer faces of the wall, and on the webs [kg]."""
    block = solid.block
    lattice = np.empty((len(block.cells), 3, 3, 3, 3))
    i, j, k = block.reference.lattice.T
    lattice[:, i, j, k] = block.points[block.cells]
    is_web = block.part >= len(solid.blade.panels)
    faces = np.where(is_web[:, None, None, None], lattice[:, :, :, 1], lattice[:, :, :, 2])
    N, dN = _shapes(_GAUSS), _slopes(_GAUSS)
    a, b = (np.einsum("pi,qj,cijx->cpqx", *pair, faces) for pair in ((dN, N), (N, dN)))
    area = np.linalg.norm(np.cross(a, b), axis=-1) @ _WEIGHTS @ _WEIGHTS
    return np.dot(area, [mass_per_area(plies) for plies in solid.laminates])


def mass_of_layers(blade, stations=400, places=1500):
    """The same from the layers of the file, without mesh, cells or laminates [kg]."""
    edges, a = np.linspace(0.0, 1.0, stations + 1), np.linspace(0.0, 1.0, places + 1)
    outer = blade.surface(edges[:, None], a)
    first, second = outer[1:, 1:] - outer[:-1, :-1], outer[1:, :-1] - outer[:-1, 1:]
    areas = 0.5 * np.linalg.norm(np.cross(first, second), axis=-1)
    s, arc = 0.5 * (edges[1:] + edges[:-1]), 0.5 * (a[1:] + a[:-1])
    mass = 0.0
    for layer in blade.layers:
        covered = (layer.start(s)[:, None] <= arc) & (arc <= layer.end(s)[:, None])
        mass += layer.material.density * layer.thickness_at(s) @ np.sum(areas * covered, axis=1)
    for number, web in enumerate(blade.inner_webs):
        arcs = blade.web_arcs(number, s)
        ends = blade.surface(s[:, None], arcs)
        height = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        height -= blade.wall(s[:, None], arcs).sum(axis=1)
        there = (web.web.start <= s) & (s <= web.web.end)
        for layer in web.layers:
            thickness = layer.thickness_at(s) * layer.share(s, 0.0, 1.0)
            mass += layer.material.density * (thickness * height) @ there * blade.length / stations
    return mass
