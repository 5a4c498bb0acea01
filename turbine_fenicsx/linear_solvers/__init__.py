"""Linear solvers of the step, one file each."""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.machine import machine_memory
from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.iterative import SectionMultigrid
from turbine_fenicsx.linear_solvers.memory import BodyCounts, choose_by_memory
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.linear_solvers.substructures import free_factor
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem


def frozen_factor(step: StepBlocks, prefix: str) -> LinearSolver:
    """Frozen elimination improved by Broyden's method; without flexible bodies exact anyway."""
    if not step.system.flexible_bodies:
        return Elimination(step, prefix)
    name = f"{prefix}free_"
    return QuasiNewton(step, FrozenElimination(step, partial(free_factor, prefix=name)))


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


def choose_solver(name: str, system: MultibodySystem) -> str:
    """Resolve "auto" by the memory that a factor needs and that the machines have. Collective.

    Args:
        name: A key of `LINEAR_SOLVERS`, or "auto".
        system: The system.
    """
    if name != "auto":
        return name
    models, ranks = system.flexible_models, system.comm.size
    meshes, available = [_count(model) for model in models], machine_memory(system.comm)
    found = choose_by_memory(meshes, ranks, False, available)
    largest = max(models, key=lambda model: model.n_owned, default=None)
    if found == "iterative" and ranks == 1 and largest and _has_equal_parts(largest):
        found = choose_by_memory(meshes, ranks, True, available)
    return found


def _count(model: FlexibleModel) -> BodyCounts:
    """Cells, vertices and nodes of a body, on all ranks."""
    mesh = model.body.mesh
    mesh.topology.create_entities(0)
    cells, vertices = (int(mesh.topology.index_map(d).size_global) for d in (3, 0))
    nodes = int(model.space.dofmap.index_map.size_global)
    return BodyCounts(_compat.cell_name(mesh), cells, vertices, nodes)


def _has_equal_parts(model: FlexibleModel) -> bool:
    """Whether its mesh, on one rank, falls into several parts of as many nodes each."""
    cells = _compat.dofs_of_cells(model.space)
    edges = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    graph = csr_matrix((np.ones(cells.size), edges), (model.n_owned,) * 2)
    parts = np.bincount(connected_components(graph, directed=False)[1])
    return parts.size > 1 and bool(np.all(parts == parts[0]))


__all__ = [
    "LINEAR_SOLVERS",
    "Elimination",
    "FrozenElimination",
    "LinearSolver",
    "MonolithicLU",
    "QuasiNewton",
    "SectionMultigrid",
    "choose_solver",
]
