"""Linear solvers of the step, one file each."""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx import _compat
from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.iterative import SectionMultigrid
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.linear_solvers.shared import shared_factor
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem


def frozen_factor(step: StepBlocks, prefix: str) -> LinearSolver:
    """Frozen elimination improved by Broyden's method; without flexible bodies exact anyway."""
    if not step.system.flexible_bodies:
        return Elimination(step, prefix)
    name = f"{prefix}free_"
    return QuasiNewton(step, FrozenElimination(step, partial(shared_factor, prefix=name)))


def conjugate_gradients(step: StepBlocks, prefix: str) -> LinearSolver:
    """Conjugate gradients in place of the frozen factor, for sizes that no factor can hold."""
    if not step.system.flexible_bodies:
        return Elimination(step, prefix)
    name = f"{prefix}free_"
    solver = FrozenElimination(step, lambda f, c, A, free: SectionMultigrid(f, c, A, free, name))
    return QuasiNewton(step, solver)


LINEAR_SOLVERS: dict[str, Callable[[StepBlocks, str], LinearSolver]] = {
    "frozen": frozen_factor,
    "iterative": conjugate_gradients,
    "lu": Elimination,
    "monolithic": MonolithicLU,
}
"""The selectable linear solvers by name (`solver.linear_solver` in case files)."""

LARGEST_FACTOR = 500_000
"""From this number of displacements on, "auto" takes the iterative solver for solid bodies.

On one rank those of the largest connected component of a mesh count, such as a blade, as each has
a factor of its own or shares one: three equal blades of 400 000 displacements each take 5 s per
step and 7.9 GB, with the iterative solver 11 s and 9.5 GB.
"""

SOLID = {"hexahedron": 0.75, "tetrahedron": 4.0}
"""Cells per vertex above which a mesh is solid: some 7 x 7 hexahedra in a section.

Thin walls and slender rods have fewer, and their factor grows hardly faster than their mesh: a
tube of 520 560 displacements, one cell through the wall, takes 13 s and 2.8 GB.
"""


def choose_solver(name: str, system: MultibodySystem) -> str:
    """Resolve "auto" by the size of the largest solid body, or of a component of it.

    Args:
        name: A key of `LINEAR_SOLVERS`, or "auto".
        system: The system.
    """
    if name != "auto":
        return name
    large = False
    for model in system.flexible_models:
        mesh, displacements = model.body.mesh, 3 * _count_nodes(model)
        mesh.topology.create_entities(0)
        counts = (mesh.topology.index_map(d).size_global for d in (3, 0))
        large |= is_for_iteration(displacements, _compat.cell_name(mesh), *counts)
    return "iterative" if large else "frozen"


def _count_nodes(model: FlexibleModel) -> int:
    """Nodes of a body, on one rank of the largest component of its mesh."""
    nodes = model.space.dofmap.index_map.size_global
    if model.body.mesh.comm.size > 1 or 3 * nodes < LARGEST_FACTOR:
        return int(nodes)
    cells = _compat.dofs_of_cells(model.space)
    edges = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    graph = csr_matrix((np.ones(cells.size), edges), (nodes, nodes))
    return int(np.max(np.bincount(connected_components(graph, directed=False)[1])))


def is_for_iteration(displacements: int, cell: str, cells: int, vertices: int) -> bool:
    """Whether a mesh is so large and so solid that its factor is worth avoiding.

    Args:
        displacements: Number of displacements.
        cell: "hexahedron" or "tetrahedron".
        cells: Number of cells.
        vertices: Number of their corners.
    """
    return displacements >= LARGEST_FACTOR and cells > SOLID[cell] * vertices


__all__ = [
    "LARGEST_FACTOR",
    "LINEAR_SOLVERS",
    "Elimination",
    "FrozenElimination",
    "LinearSolver",
    "MonolithicLU",
    "QuasiNewton",
    "SectionMultigrid",
    "choose_solver",
    "is_for_iteration",
]
