"""Linear solvers of the step, one file each."""

from collections.abc import Callable

from turbine_fenicsx.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.linear.base import LinearSolver
from turbine_fenicsx.linear.elimination import Elimination
from turbine_fenicsx.linear.frozen import FrozenElimination
from turbine_fenicsx.linear.monolithic import MonolithicLU
from turbine_fenicsx.linear.quasi_newton import QuasiNewton


def frozen(step: EnergyMomentumStep, prefix: str) -> LinearSolver:
    """Frozen elimination improved by Broyden's method; without flexible bodies exact anyway."""
    if not step.system.flexible_bodies:
        return Elimination(step, prefix)
    return QuasiNewton(step, FrozenElimination(step, prefix))


LINEAR_SOLVERS: dict[str, Callable[[EnergyMomentumStep, str], LinearSolver]] = {
    "frozen": frozen,
    "lu": Elimination,
    "monolithic": MonolithicLU,
}
"""The selectable linear solvers by name (`solver.preconditioner` in case files)."""

__all__ = [
    "LINEAR_SOLVERS",
    "Elimination",
    "FrozenElimination",
    "LinearSolver",
    "MonolithicLU",
    "QuasiNewton",
]
