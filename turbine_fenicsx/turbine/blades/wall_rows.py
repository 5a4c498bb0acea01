"""Rows of cells around a hollow blade: each is the wall of one section of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.laminate_theory import Plies
from turbine_fenicsx.meshing.hollow import HollowBlock, mesh_hollow
from turbine_fenicsx.meshing.hollow_ends import HEXAHEDRON
from turbine_fenicsx.reduction.beam_elements import BeamElements, Places
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.turbine.blades.wall_cells import WallCells
from turbine_fenicsx.windio.blade import WindIOBlade

AT = {tuple(place): k for k, place in enumerate(HEXAHEDRON.lattice.tolist())}
"""Nodes of a cell by their places along the span, around the section and outwards, from 0 to 2."""


PIECES = 100
"""Number of straight pieces of the axis that points are located along."""


@dataclass(frozen=True, eq=False)
class WallRows:
    """Cells of a blade without a plate at its tip, row by row from the root.

    Args:
        line: Axis of the sections, from the rotor centre along a1, a2, a3.
        block: The mesh.
        cells: Its cells.
    """

    line: BeamLine
    block: HollowBlock
    cells: WallCells

    @classmethod
    def of(cls, blade: WindIOBlade, line: BeamLine, span: int, around: int) -> WallRows:
        """Those of a mesh of a blade with a layup.

        Args:
            span: Number of rows.
            around: Number of cells around a section, without those of webs.
        """
        block = mesh_hollow(replace(blade, closed_tip=False), span, around)
        return cls(line, block, WallCells.read(blade, block.cell_data))

    @cached_property
    def plies(self) -> Sequence[Plies]:
        """Plies of each cell."""
        return self.cells.find_plies()

    @cached_property
    def rows(self) -> list[IntArray]:
        """Numbers of the cells of each row."""
        _, row = np.unique(self.cells.span[:, 0], return_inverse=True)
        return [np.flatnonzero(row == k) for k in range(int(row.max()) + 1)]

    @cached_property
    def stations(self) -> Array:
        """Arc lengths of the middles of the rows, shape (rows,) [m]."""
        s = self.locate(self.block.points[self.nodes_at([(1, 1, 1)])[:, 0]]).s
        return np.array([s[row].mean() for row in self.rows])

    def nodes_at(self, places: Sequence[tuple[int, int, int]]) -> IntArray:
        """Nodes of each cell at some places, shape (cells, places)."""
        return self.block.cells[:, [AT[place] for place in places]]

    def locate(self, points: Array) -> Places:
        """Points as places in sections, along the axis and its directors."""
        return BeamElements(self.line, PIECES, 1).locate(points)
