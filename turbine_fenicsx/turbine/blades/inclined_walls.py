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

from dataclasses import replace

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.laminate_theory import Plies, laminate_stiffness
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_ends import HEXAHEDRON
from turbine_fenicsx.reduction.beam_elements import BeamElements
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.turbine.blades.wall_cells import WallCells
from turbine_fenicsx.windio.blade import WindIOBlade

SPAN, AROUND = 40, 32
"""Elements of the mesh whose cells are the pieces of wall."""


def find_inclination(blade: WindIOBlade, line: BeamLine, stations: Array) -> Array:
    """The part sum w (g g^T - g_0 g_0^T) of section matrices.

    Args:
        blade: A blade with a layup.
        line: Axis of the sections from the rotor centre along a1, a2, a3.
        stations: Arc lengths along it, shape (m,) [m].

    Returns:
        Shape (m, 6, 6), straight between rows of cells, and zero at the free end, which has no
        axial stress.
    """
    block = mesh_hollow(replace(blade, closed_tip=False), SPAN, AROUND)
    cells = WallCells.read(blade, block.cell_data)
    w = np.array([_stretch_stiffness(plies) for plies in cells.find_plies()])
    at = {tuple(place): k for k, place in enumerate(HEXAHEDRON.lattice.tolist())}
    X = block.points[block.cells]
    middle, along = X[:, at[1, 1, 1]], X[:, at[2, 1, 1]] - X[:, at[0, 1, 1]]
    around = X[:, at[1, 2, 1]] - X[:, at[1, 0, 1]]
    w *= np.linalg.norm(np.cross(along, around), axis=1) / np.linalg.norm(along, axis=1)
    sections = BeamElements(line, SPAN, 1)
    s, x, y = sections.locate(middle)
    _, d = line.at(s)
    normal = np.cross(d[:, 0], d[:, 1])
    a, b = np.einsum("kai,ki->ak", d, along) / np.sum(normal * along, axis=1)
    one, none = np.ones_like(x), np.zeros_like(x)
    g = np.stack([a, b, one, y, -x, x * b - y * a])
    g_0 = np.stack([none, none, one, y, -x, none])
    parts = np.einsum("k,ik,jk->kij", w, g, g) - np.einsum("k,ik,jk->kij", w, g_0, g_0)
    _, row, count = np.unique(cells.span[:, 0], return_inverse=True, return_counts=True)
    sums, places = np.zeros((len(count), 6, 6)), np.bincount(row, s) / count
    np.add.at(sums, row, parts)
    places = np.append(places, line.length)
    sums = np.concatenate([sums, np.zeros((1, 6, 6))])
    columns = [np.interp(stations, places, column) for column in sums.reshape(-1, 36).T]
    return np.column_stack(columns).reshape(-1, 6, 6)


def _stretch_stiffness(plies: Plies) -> float:
    """Stiffness along the span of a wall that is free across, over its width [N/m]."""
    A = laminate_stiffness(plies)[0]
    return float(1.0 / np.linalg.inv(A)[0, 0])
