"""Convergence of a step, block by block."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.time_stepping.nested_step import NestedStep
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

LAST_GAIN = {"exact": 0.03, "approximate": 0.5}
"""Below the round-off of the elastic forces an iteration ends once a step gains less than this.

Then what is left is noise, which is not along the motion and so does hardly any work. An exact
tangent that gains no more than this has come to rest. An approximate one gains a digit per
iteration or less on its way, so that it has come to rest only where nothing is gained. Ending at
the first gain of less than 0.03 would cost a digit of the energy balance of thin walls, which have
much noise: 2e-11 instead of 9e-13 over fifty steps of a hollow rotor. It would save a sixth of an
iteration per step of the paper's stiff case.
"""

DIVERGENCE = 1e4
"""An iteration whose residual grows by this factor is given up."""


@dataclass
class BlockwiseConvergence:
    """Convergence by the largest relative residual of the blocks, in units of its tolerance."""

    step: NestedStep
    options: SolverOptions
    history: list[float] = field(default_factory=list)
    stagnation: float = 0.0
    last_gain: float = LAST_GAIN["exact"]

    def __post_init__(self) -> None:
        """Lay out the tolerances like `NestedStep.relative_residuals`."""
        n = len(self.step.system.flexible_models)
        balance, constraint = self.options.tolerance, 0.01 * self.options.tolerance
        self._tolerances = np.array(
            [balance] * n + [constraint] * n + [balance] * 2 + [constraint] * 2
        )

    def start_iteration(self, approximate: bool) -> None:
        """A new iteration begins; with an approximate tangent slow ones look like round-off."""
        self.history.clear()
        self.stagnation = (0.02 if approximate else 1.0) * self.options.stagnation
        self.last_gain = LAST_GAIN["approximate" if approximate else "exact"]

    @property
    def keeps_tangent(self) -> bool:
        """Whether the last tangent, of an earlier step perhaps, serves in this iteration too.

        It does in the first of a step, and where one more like the last ends the step.
        """
        if len(self.history) < 2:
            return True
        before, now = self.history[-2:]
        return now * now <= before

    def __call__(self, snes: PETSc.SNES, iteration: int, norms: Any) -> int:
        """SNES convergence test."""
        reasons = PETSc.SNES.ConvergedReason
        R = snes.getFunction()[0]
        worst = self._find_worst(R)
        self.history.append(worst)
        if not np.isfinite(worst):
            return _compat.NOT_A_NUMBER
        if worst <= 1.0:
            return int(reasons.CONVERGED_FNORM_RELATIVE)
        gains_little = worst > self.last_gain * min(self.history[:-1], default=np.inf)
        if gains_little and self._find_worst(R, beyond_round_off=True) <= 1.0:
            return int(reasons.CONVERGED_SNORM_RELATIVE)
        stagnant = iteration >= 4 and worst > 0.5 * max(self.history[-5:-1])
        if stagnant and worst * self.options.tolerance <= self.stagnation:
            return int(reasons.CONVERGED_SNORM_RELATIVE)
        if worst > DIVERGENCE * self.history[0]:
            return int(reasons.DIVERGED_DTOL)
        if iteration >= self.options.max_iterations:
            return int(reasons.DIVERGED_MAX_IT)
        return 0

    def _find_worst(self, R: PETSc.Vec, beyond_round_off: bool = False) -> float:
        """The largest of the relative residuals, in units of its tolerance. Collective."""
        relative = self.step.relative_residuals(R, beyond_round_off) / self._tolerances
        return float(relative.max())
