"""Memory that a run with a linear solver needs, and the solver that this leaves.

Fits to what runs of slender solid blades took at most, see `benchmarks/README.md`; within a third.
"""

from __future__ import annotations

from collections.abc import Sequence

from turbine_fenicsx.linear_solvers.substructures import WIDEST
from turbine_fenicsx.meshing.size import MeshSize

PROGRAM = 0.17e9
"""Memory of a rank without unknowns [B]."""

QUADRATIC_HEXAHEDRA = 1.8
"""Their memory over that of other cells with as many displacements: their rows are longer."""

EQUAL_PARTS = 5.4e3
"""Memory for each displacement of three equal blades that share a factor [B]. Measured on one rank
with 70 713, 220 545, 301 725, 575 000, 1 202 607 displacements: 0.54, 1.42, 1.84, 3.5, 7.9 GB, and
0.45 and 1.58 GB with the first and the third since a matrix is freed before the factor is made."""

ITERATIVE = 4.5e3
"""Memory for each displacement with the iterative solver [B]. Measured on one rank with 70 713 and
220 545 displacements: 0.46 and 1.19 GB."""

SEVERAL_RANKS = 1.35
"""Memory of several ranks over that of one; measured on two with 302 000 displacements, 3.94 GB
with a factor for each part and 2.48 GB with one for all, and 0.77 GB with 70 713."""

FITS = 0.75
"""Part of the machine's memory that a run may need by the estimate, which is within a third."""

SOLID = {"hexahedron": 0.75, "tetrahedron": 4.0}
"""Cells per vertex above which a mesh is solid: some 7 x 7 hexahedra in a section.

Thin walls and slender rods have fewer, and their factor grows hardly faster than their mesh: a
tube of 520 560 displacements, one cell through the wall, takes 13 s and 2.8 GB.
"""


def shares_factor(mesh: MeshSize, ranks: int) -> bool:
    """Whether equal parts of a mesh will share a factor on each of so many ranks.

    They do where the slabs of a rank are cut alike, and what surrounds them is small enough for
    `turbine_fenicsx.linear_solvers.substructures`.
    """
    if not mesh.is_cut_alike(ranks):
        return False
    corners = mesh.vertices / (mesh.parts * (mesh.layers + 1))
    section = 3.0 * corners * (mesh.nodes / mesh.vertices) ** (2.0 / 3.0)
    around = min(ranks - 1, 2) * section
    return bool(mesh.parts * around**2 <= WIDEST * 3.0 * mesh.nodes / ranks)


def estimate_memory(solver: str, meshes: Sequence[MeshSize], ranks: int, shared: bool) -> float:
    """Memory of all ranks [B].

    Args:
        solver: A key of `LINEAR_SOLVERS`.
        meshes: Meshes of the flexible bodies.
        ranks: Number of ranks.
        shared: Whether the large one is of equal parts that share a factor on each rank.
    """
    found = 0.0
    for mesh in meshes:
        n = 3.0 * mesh.nodes
        quadratic = mesh.nodes > 2 * mesh.vertices
        longer = QUADRATIC_HEXAHEDRA if quadratic and mesh.cell == "hexahedron" else 1.0
        needed = ITERATIVE * n if solver == "iterative" else 630.0 * n**1.2
        if solver == "frozen" and shared:
            needed = min(needed, EQUAL_PARTS * n)
        found += longer * needed
    return ranks * PROGRAM + found * (SEVERAL_RANKS if ranks > 1 else 1.0)


def choose_by_memory(meshes: Sequence[MeshSize], ranks: int, shared: bool, available: float) -> str:
    """The frozen factor, or the iterative solver where the factor of a solid body does not fit.

    A factor that fits is the faster one: three blades of 400 000 displacements each take 5 s per
    step, with the iterative solver 11 s.

    Args:
        meshes: Meshes of the flexible bodies.
        ranks: Number of ranks.
        shared: Whether the large one is of equal parts that share a factor on each rank.
        available: Memory that all ranks may use [B].
    """
    if estimate_memory("frozen", meshes, ranks, shared) <= FITS * available:
        return "frozen"
    largest = max(meshes, key=lambda mesh: mesh.nodes, default=None)
    solid = largest is not None and largest.cells > SOLID[largest.cell] * largest.vertices
    return "iterative" if solid else "frozen"
