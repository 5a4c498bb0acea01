"""Linear solvers of the step, one file each."""

from collections.abc import Callable

from turbine_fenicsx.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.linear.base import LinearSolver
from turbine_fenicsx.linear.elimination import Elimination
from turbine_fenicsx.linear.monolithic import MonolithicLU

LINEAR_SOLVERS: dict[str, Callable[[EnergyMomentumStep, str], LinearSolver]] = {
    "lu": Elimination,
    "monolithic": MonolithicLU,
}
"""The selectable linear solvers by name (`solver.preconditioner` in case files)."""

__all__ = ["LINEAR_SOLVERS", "Elimination", "LinearSolver", "MonolithicLU"]
