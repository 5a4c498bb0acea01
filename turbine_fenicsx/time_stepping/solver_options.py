"""Tolerances and linear solver of a step."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS


@dataclass(frozen=True)
class SolverOptions:
    """Options of the step solver.

    Args:
        linear_solver: Name of the linear solver, a key of `LINEAR_SOLVERS`.
        tolerance: Relative residual of the balance equations, |R| <= tolerance * sum |terms| in
            each block; constraints take a hundredth of it.
        stagnation: A residual that no longer decreases is taken as round-off if it is below this,
            or below the estimated round-off of the elastic forces.
        max_iterations: Largest number of Newton iterations.
        prefix: Prefix of the PETSc options.

    Raises:
        ModelError: for an unknown linear solver or a tolerance outside (0, 1).
    """

    linear_solver: str = "frozen"
    tolerance: float = 1e-12
    stagnation: float = 1e-9
    max_iterations: int = 30
    prefix: str = "tfx_"

    def __post_init__(self) -> None:
        """Check the options."""
        if self.linear_solver not in LINEAR_SOLVERS:
            raise ModelError(
                f"solver.linear_solver must be one of {sorted(LINEAR_SOLVERS)}, "
                f"got {self.linear_solver!r}"
            )
        if not 0.0 < self.tolerance < 1.0:
            raise ModelError(f"solver.tolerance must lie between 0 and 1, got {self.tolerance}")
