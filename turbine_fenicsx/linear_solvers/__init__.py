"""Linear solvers of the step, one file each."""

from collections.abc import Callable
from functools import partial

from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.choice import choose_solver
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.iterative import SectionMultigrid
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.linear_solvers.substructures import free_factor


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
