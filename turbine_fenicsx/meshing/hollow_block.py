"""The mesh of one hollow blade, with what each cell is part of."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.block import BladeBlock


@dataclass(frozen=True)
class HollowBlock(BladeBlock):
    """Nodes and quadratic hexahedra of a hollow blade, one cell through the wall.

    The columns of the Jacobian are the axes of the wall. The axes of each reference cell point
    along the span, around the section and through the wall outwards. Around means towards rising
    contour fractions, in a web from suction to pressure side; outwards means in a web towards the
    leading edge. In the plate of a closed tip they point from suction to pressure side, to the
    leading edge, and along the span.

    Attributes:
        parts: Names of panels, webs, and the plate of a closed tip.
        part: Index in ``parts`` of each cell, shape (n_cells,).
        span: First and last span fraction of each cell, shape (n_cells, 2) [-].
        arc: First and last contour fraction of each cell of a panel, and on the suction side of the
            tip; of a web, fractions of its height from suction to pressure side;
            shape (n_cells, 2) [-].
        wanted: Thickness of the wall that each cell stands for, shape (n_cells,) [m].
        thickness: Thickness that the cell has; it is smaller where walls would cross,
            shape (n_cells,) [m].
    """

    parts: tuple[str, ...]
    part: IntArray
    span: Array
    arc: Array
    wanted: Array
    thickness: Array

    @property
    def cell_data(self) -> dict[str, Array]:
        """The attributes of each cell, both ends of its ranges apart, shape (n_cells,) each."""
        return {
            "part": self.part.astype(float),
            "span_start": self.span[:, 0],
            "span_end": self.span[:, 1],
            "arc_start": self.arc[:, 0],
            "arc_end": self.arc[:, 1],
            "wanted": self.wanted,
            "thickness": self.thickness,
        }
