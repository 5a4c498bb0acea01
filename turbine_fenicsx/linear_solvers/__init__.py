"""Linear solvers of the step, one file each."""

from collections.abc import Callable
from functools import partial

from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.iterative import SectionMultigrid
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.linear_solvers.substructures import free_factor


def make_quasi_newton(
    make_solver: Callable[..., FreeSolver], step: StepBlocks, prefix: str
) -> LinearSolver:
    """Frozen elimination improved by Broyden's method; exact if all bodies are rigid or small.

    Args:
        make_solver: A `SolverMaker` that takes the options prefix, too.
        step: The step whose tangent is solved with.
    """
    if not step.system.has_large_bodies:
        return Elimination(step, prefix)
    return QuasiNewton(step, FrozenElimination(step, partial(make_solver, prefix=f"{prefix}free_")))


LINEAR_SOLVERS: dict[str, Callable[[StepBlocks, str], LinearSolver]] = {
    "frozen": partial(make_quasi_newton, free_factor),
    "iterative": partial(make_quasi_newton, SectionMultigrid),
    "lu": Elimination,
    "monolithic": MonolithicLU,
}
"""The selectable linear solvers by name (`solver.linear_solver` in case files)."""
