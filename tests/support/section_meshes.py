"""Meshes of cross-sections."""

from itertools import pairwise

from mpi4py import MPI

import numpy as np
from dolfinx import mesh as meshes

from turbine_fenicsx import _compat

GMSH_ORDER = (0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)
"""Places of the nodes of a quadratic quadrilateral."""


def quadrilaterals(points, cells):
    """A mesh on this rank, in the plane of x and y of space."""
    points = np.column_stack([points, np.zeros(len(points))])
    return _compat.mesh_of_arrays(MPI.COMM_SELF, "quadrilateral", 1, points, np.asarray(cells))


def grid(x, y, keep):
    """Cells between lines x and y whose middles are kept."""
    X, Y = np.meshgrid(x, y, indexing="ij")
    number = np.arange(X.size).reshape(X.shape)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    cells = np.stack([c.ravel() for c in corners], axis=1)
    points = np.column_stack([X.ravel(), Y.ravel()])
    middles = points[cells].mean(axis=1)
    used, cells = np.unique(cells[keep(*middles.T)], return_inverse=True)
    return quadrilaterals(points[used], cells.reshape(-1, 4))


def rectangle(width, height, n, m, in_space):
    """A rectangle about the origin, in space or in the plane."""
    x, y = (np.linspace(-0.5, 0.5, k + 1) * a for k, a in ((n, width), (m, height)))
    if in_space:
        return grid(x, y, lambda x, y: x < np.inf)
    corners = [[x[0], y[0]], [x[-1], y[-1]]]
    return meshes.create_rectangle(MPI.COMM_SELF, corners, [n, m], meshes.CellType.quadrilateral)


def ring(curves, closed=True):
    """Cells between curves of as many points, two through each layer; from the inside."""
    layers = [curves[0]]
    for inner, outer in pairwise(curves):
        layers += [0.5 * (inner + outer), outer]
    n = len(curves[0])
    number = np.arange(n * len(layers)).reshape(-1, n)
    if closed:
        number = np.column_stack([number, number[:, 0]])
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    return quadrilaterals(np.concatenate(layers), np.stack([c.ravel() for c in corners], axis=1))


def loops(w1, w2, h, t, apart=False):
    """Two closed cells beside each other, by distances of the middles of walls; or three webs."""
    walls_x, walls_y = [np.array([a, a + t]) for a in (0.0, w1, w1 + w2)], [[0.0, t], [h, h + t]]

    def lines(walls, n=24):
        ends = np.concatenate(walls)
        parts = [np.linspace(a, b, n + 1) for a, b in zip(ends[1:-1:2], ends[2::2], strict=True)]
        middles = [np.mean(wall) for wall in walls]
        return np.unique(np.concatenate([ends, *parts, middles]))

    def keep(x, y):
        in_web = np.any([(a < x) & (x < b) for a, b in walls_x], axis=0)
        in_flange = np.any([(a < y) & (y < b) for a, b in walls_y], axis=0)
        return in_web if apart else in_web | in_flange

    return grid(lines(walls_x), lines(walls_y), keep)


def wall_ring(inner, outer, n):
    """One quadratic cell through the wall of a tube, n around; its axes are around and outwards."""
    angle = np.linspace(0.0, 2.0 * np.pi, 2 * n + 1)[:-1]
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([r * circle for r in (inner, 0.5 * (inner + outer), outer)])
    number = np.arange(6 * n).reshape(3, 2 * n)
    j = 2 * np.arange(n)
    at = [number[k, (j + i) % (2 * n)] for i, k in GMSH_ORDER]
    points = np.column_stack([points, np.zeros(len(points))])
    cells = np.stack(at, axis=1)
    return _compat.mesh_of_arrays(MPI.COMM_SELF, "quadrilateral", 2, points, cells)
