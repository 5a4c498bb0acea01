"""Numbers of a mesh, by which time and memory are estimated."""

from __future__ import annotations

from dataclasses import dataclass

THINNEST = 6
"""Layers of cells that a rank has of each equal part at least, and never fewer than there are
ranks: what all ranks solve for, where they meet, grows with their number, what each holds becomes
thinner."""


@dataclass(frozen=True)
class MeshSize:
    """Numbers of a mesh with displacements of a given degree.

    Args:
        cell: "hexahedron" or "tetrahedron".
        cells: Number of cells.
        vertices: Number of their corners.
        nodes: Number of nodes of the displacement.
        root_nodes: How many of them are coupled: on the roots, or on both ends of the tower.
        exact: Whether these are counted; else they are some ten per cent off.
        parts: Number of equal parts, such as blades, that nothing connects; 1 without.
        layers: Layers of cells along each of them; 0 without.
    """

    cell: str
    cells: int
    vertices: int
    nodes: int
    root_nodes: int = 0
    exact: bool = True
    parts: int = 1
    layers: int = 0

    def is_cut_alike(self, ranks: int) -> bool:
        """Whether each of so many ranks gets the same slab of every equal part."""
        return self.parts > 1 and (ranks == 1 or self.layers // ranks >= max(THINNEST, ranks))
