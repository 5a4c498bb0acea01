"""Linear solvers of the step, one file each."""

from collections.abc import Callable

from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.iterative import SectionMultigrid
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.system import MultibodySystem


def frozen_factor(step: StepBlocks, prefix: str) -> LinearSolver:
    """Frozen elimination improved by Broyden's method; without flexible bodies exact anyway."""
    if not step.system.flexible_bodies:
        return Elimination(step, prefix)
    name = f"{prefix}free_"
    solver = FrozenElimination(step, lambda f, c, A, free: SymmetricFactor(A, name))
    return QuasiNewton(step, solver)


def conjugate_gradients(step: StepBlocks, prefix: str) -> LinearSolver:
    """The same with conjugate gradients in place of the factor, for sizes no factor can hold."""
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
"""From this number of displacements on, "auto" takes the iterative solver."""


def choose_solver(name: str, system: MultibodySystem) -> str:
    """Resolve "auto" by the size of the largest flexible body.

    Args:
        name: A key of `LINEAR_SOLVERS`, or "auto".
        system: The system.
    """
    if name != "auto":
        return name
    sizes = (3 * f.space.dofmap.index_map.size_global for f in system.flexible_models)
    return "iterative" if max(sizes, default=0) >= LARGEST_FACTOR else "frozen"


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
]
