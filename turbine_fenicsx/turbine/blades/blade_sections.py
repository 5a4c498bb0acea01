"""Sections of a hollow blade, found from its layup, and what beam codes need of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import WallTable, tabulate_walls
from turbine_fenicsx.reduction.beam_sections import BeamSections
from turbine_fenicsx.sections.section import Section, analyse_section
from turbine_fenicsx.turbine.blades.inclined_walls import find_inclination
from turbine_fenicsx.turbine.blades.wall_rows import WallRows

FACE = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
"""Nodes of a quadrilateral, around the section and outwards, in the order of gmsh."""


@dataclass(frozen=True, eq=False)
class BladeSections:
    """Sections in the middles of rows of cells.

    Axes x and y are the directors of the axis there, and all matrices are about it.

    Args:
        walls: The rows of cells.
        sections: Each as a prism, m of them.
        inclination: What inclined walls add to the stiffness, shape (m, 6, 6).
    """

    walls: WallRows
    sections: tuple[Section, ...]
    inclination: Array

    @property
    def stations(self) -> Array:
        """Arc lengths, shape (m,) [m]."""
        return self.walls.stations

    @property
    def length(self) -> float:
        """Of the axis [m]."""
        return self.walls.line.length

    @cached_property
    def stiffness(self) -> Array:
        """Of prisms, shape (m, 6, 6)."""
        return np.array([section.stiffness for section in self.sections])

    @cached_property
    def inertia(self) -> Array:
        """Mass matrices, shape (m, 6, 6)."""
        return np.array([section.inertia for section in self.sections])

    def find_cells(self, k: int) -> IntArray:
        """Numbers of the cells of a row, in the order of the cells of its section."""
        order = np.asarray(self.sections[k].mesh.topology.original_cell_index)
        cells: IntArray = self.walls.rows[k][order]
        return cells

    def as_beam(self, taper: bool, mu: tuple[float, ...] = (0.0,) * 6) -> BeamSections:
        """Matrices from one end of the axis to the other; those of the first and last row there.

        Args:
            taper: Whether walls are inclined, or those of prisms.
            mu: Times of stiffness-proportional damping of each strain [s].
        """
        C = self.stiffness + taper * self.inclination
        s = np.concatenate([[0.0], self.stations, [self.length]])
        ends = np.concatenate([[0], np.arange(len(C)), [len(C) - 1]])
        return BeamSections(s, C[ends], self.inertia[ends], mu)


def analyse_rows(
    walls: WallRows, moments: bool, found: Callable[[int], object] = lambda done: None
) -> BladeSections:
    """Analyse the section of each row.

    Args:
        moments: Whether walls have the bending stiffness of their layup too.
        found: Called after each with the number of those that are done.
    """
    table = tabulate_walls(walls.plies, walls.cells.thickness, moments)
    sections = []
    for k in range(len(walls.rows)):
        sections.append(analyse_row(walls, k, table))
        found(k + 1)
    inclination = find_inclination(walls, walls.stations)
    return BladeSections(walls, tuple(sections), inclination)


def analyse_row(walls: WallRows, k: int, table: WallTable) -> Section:
    """The section in the middle of a row, of walls with the stiffness and density of a table."""
    row = walls.rows[k]
    nodes, cells = np.unique(
        walls.nodes_at([(1, *place) for place in FACE])[row], return_inverse=True
    )
    place = walls.locate(walls.block.points[nodes])
    flat = np.column_stack([place.xi, place.eta, np.zeros(len(nodes))])
    cells = cells.reshape(-1, len(FACE))
    mesh = _compat.mesh_of_arrays(MPI.COMM_SELF, "quadrilateral", 2, flat, cells)
    own = table[row[np.asarray(mesh.topology.original_cell_index)]]
    return analyse_section(mesh, Laminate.from_table(mesh, own), cell_field(mesh, own.density))
