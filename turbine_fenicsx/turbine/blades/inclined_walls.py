"""The part of section matrices that inclined walls add, beyond those of a prism.

Axial stress follows the lines along which layup and walls run. Where a line at x, y of a section
leaves its normal with the slopes a = dx/ds and b = dy/ds, the strains of the section stretch it by
g.e, and the line of a prism by g_0.e, with

    g = (a, b, 1, y, -x, x b - y a),    g_0 = (0, 0, 1, y, -x, 0).

With the stiffness w = int E dA of each piece of wall the matrix C of a prism becomes

    C' = C + sum w (g g^T - g_0 g_0^T).

It couples bending with torsion. Warping, shear flow and the shape of the section stay those of the
prism.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.laminate_theory import Plies, laminate_stiffness
from turbine_fenicsx.turbine.blades.wall_rows import WallRows


def find_inclination(walls: WallRows, stations: Array) -> Array:
    """The part sum w (g g^T - g_0 g_0^T) of section matrices.

    Args:
        walls: Rows of cells, which are the pieces of wall.
        stations: Arc lengths along the axis, shape (m,) [m].

    Returns:
        Shape (m, 6, 6), straight between rows of cells, and zero at the free end, which has no
        axial stress.
    """
    w = np.array([_stretch_stiffness(plies) for plies in walls.plies])
    nodes = walls.nodes_at([(1, 1, 1), (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1)])
    middle, root, tip, before, behind = walls.block.points[nodes].swapaxes(0, 1)
    along, around = tip - root, behind - before
    w *= np.linalg.norm(np.cross(along, around), axis=1) / np.linalg.norm(along, axis=1)
    s, x, y = walls.locate(middle)
    _, d = walls.line.at(s)
    normal = np.cross(d[:, 0], d[:, 1])
    a, b = np.einsum("kai,ki->ak", d, along) / np.sum(normal * along, axis=1)
    parts = incline(w, x, y, a, b)
    sums = np.array([parts[row].sum(axis=0) for row in walls.rows] + [np.zeros((6, 6))])
    return interpolate_matrices(stations, np.append(walls.stations, walls.line.length), sums)


def incline(w: Array, x: Array, y: Array, a: Array, b: Array) -> Array:
    """The part w (g g^T - g_0 g_0^T) of each of n pieces of wall, shape (n, 6, 6).

    Args:
        w: Stiffness int E dA, shape (n,) [N].
        x: Place along the first axis of the section [m].
        y: Along the second one [m].
        a: Slope dx/ds.
        b: Slope dy/ds.
    """
    one, none = np.ones_like(x), np.zeros_like(x)
    g = np.stack([a, b, one, y, -x, x * b - y * a])
    g_0 = np.stack([none, none, one, y, -x, none])
    parts: Array = np.einsum("k,ik,jk->kij", w, g, g) - np.einsum("k,ik,jk->kij", w, g_0, g_0)
    return parts


def _stretch_stiffness(plies: Plies) -> float:
    """Stiffness along the span of a wall that is free across, over its width [N/m]."""
    A = laminate_stiffness(plies)[0]
    return float(1.0 / np.linalg.inv(A)[0, 0])
