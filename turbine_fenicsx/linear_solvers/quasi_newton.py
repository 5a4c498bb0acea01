"""Broyden's method on top of an approximate linear solver.

C. G. Broyden, Math. Comp. 19 (1965) 577-593, in the form that keeps only steps: C. T. Kelley,
Iterative Methods for Linear and Nonlinear Equations, SIAM 1995, section 7.3.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination

RENEWAL = 30.0
"""Iterations that cost as much as a new factor: 11 to 37 with 1 000 to 70 000 displacements."""

BASELINE_STEPS = 10
"""Number of steps after a refactorisation that define the baseline of iterations."""

BASELINE_MAX_ITERATIONS = 10
"""Maximum number of iterations during the baseline; more, beyond the fewest so far, count as
excess."""


class QuasiNewton:
    """Turns the chord steps of a frozen tangent into Broyden steps.

    Broyden's ("good") method improves the inverse of the tangent by a rank-one term in each
    iteration so that it reproduces the last change of the residual. In Kelley's form
    (*Iterative Methods for Linear and Nonlinear Equations*, 1995, section 7.3) only the steps
    s_0, s_1, ... need to be kept: with z = -P^{-1} R,

        for all earlier j:  z += s_{j+1} (s_j . z)/(s_j . s_j),
        s_n = z / (1 - (s_{n-1} . z)/(s_{n-1} . s_{n-1})).

    The scalar product weighs velocities with masses, so that no unit and no mesh size enters.
    No action of the tangent is ever needed: an iteration costs one residual and one solve.

    The approximate solver is refreshed after an iteration that failed, and once the iterations
    beyond those of the first steps with it would have paid for that. Where they grow steadily, the
    sum of both costs is then nearly the least; where refreshing does not help, it is not repeated,
    as there is nothing beyond what it led to. One more in a step does not count.

    Bodies with small tangents have new ones in each iteration. Then P changes, so that steps stay
    as they are; what is frozen of the other bodies alone makes them approximate.

    Args:
        step: The step; all steps belong to its Newton iteration with full steps x += s.
    """

    def __init__(self, step: StepBlocks, solver: FrozenElimination) -> None:
        """Lay out the weights."""
        self._step, self._solver = step, solver
        self._comm = step.system.comm
        self._weights = step.mass_weights()
        self._steps: list[Array] = []
        self._iterations = 0
        self._new = False
        self._excess = self._usual = 0.0
        self._settled = self._fewest = 0
        self._products: Array = np.zeros((0, 0))

    @property
    def krylov_iterations(self) -> int:
        """Krylov iterations of the approximate solver so far."""
        return self._solver.krylov_iterations

    @property
    def factors(self) -> tuple[int, int]:
        """Number of factors, and of the components of bodies that they serve."""
        return self._solver.factors

    def start_iteration(self) -> None:
        """Forget the steps of the last iteration; refresh the solver if that pays."""
        due = self._excess >= RENEWAL
        if due:
            self._solver.refresh()
        self._steps, self._iterations = [], 0
        self._products = np.zeros((0, 0))
        self._new = self._solver.start_iteration() or due
        if self._new:
            self._excess = self._usual = 0.0
            self._settled = self._fewest = 0

    def update(self, x: PETSc.Vec) -> None:
        """Update the approximate solver, once per step: Broyden's method does the rest."""
        if not self._iterations or self._solver.has_small_bodies:
            self._solver.update(x)

    def turn(self, x: PETSc.Vec) -> bool:
        """The approximate solver turns by itself."""
        return False

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """The quasi-Newton correction for the residual b; x is minus the step."""
        self._solver.solve(b, x)
        self._iterations += 1
        if self._solver.has_small_bodies:
            return
        parts = [part.array for part in x.getNestSubVecs()]
        s = self._improve(-np.concatenate(parts))
        end = 0
        for part in parts:
            start, end = end, end + part.size
            np.negative(s[start:end], out=part)

    def end_iteration(self, converged: bool) -> bool:
        """Count the iterations, for the decision to refresh the solver.

        Returns:
            Whether to retry the step: it failed with a factor of an earlier step, and a new one
            costs less than the exact tangent.
        """
        n = self._iterations
        if not converged:
            self._excess = RENEWAL
            return not self._new
        if self._settled < BASELINE_STEPS:
            self._fewest = n if self._settled == 0 else min(n, self._fewest)
            self._settled += 1
            self._usual += n / BASELINE_STEPS
            self._excess += max(n - max(self._fewest, BASELINE_MAX_ITERATIONS), 0)
        else:
            self._excess = max(self._excess + n - self._usual - 1.0, 0.0)
        return False

    def save(self) -> RestartData:
        """State of the approximate solver, and of the decision when to refresh it."""
        data = RestartData({"excess": self._excess, "usual": self._usual, "settled": self._settled})
        data.numbers["fewest"] = self._fewest
        data.add("solver", self._solver.save())
        return data

    def restore(self, data: RestartData) -> None:
        """Copy the state of another one."""
        numbers = data.numbers
        self._excess, self._usual = numbers["excess"], numbers["usual"]
        self._settled, self._fewest = int(numbers["settled"]), int(numbers["fewest"])
        self._solver.restore(data.part("solver"))

    def destroy(self) -> None:
        """Free all PETSc objects."""
        self._solver.destroy()

    def _improve(self, z: Array) -> Array:
        """The step s_n for z = -P^{-1} R, remembered. One reduction over the ranks."""
        n = len(self._steps)
        weighted = self._weights * z
        local = np.array([*(s @ weighted for s in self._steps), z @ weighted])
        dots = sum_over_ranks(self._comm, local)
        G = self._products
        # z = z_0 + sum_j c_j s_{j+1}; t_j is its product with s_j for all j, kept up to date.
        t, c = dots[:n].copy(), np.zeros(max(n - 1, 0))
        for j in range(n - 1):
            c[j] = t[j] / G[j, j]
            t += c[j] * G[:, j + 1]
        scale = 1.0 / (1.0 - t[n - 1] / G[n - 1, n - 1]) if n else 1.0
        s: Array = scale * (z + sum(a * q for a, q in zip(c, self._steps[1:], strict=True)))
        square = dots[n] + 2.0 * (c @ dots[1:n]) + c @ G[1:, 1:] @ c if n > 1 else dots[n]
        grown = np.zeros((n + 1, n + 1))
        grown[:n, :n] = G
        grown[:n, n] = grown[n, :n] = scale * t
        grown[n, n] = scale**2 * square
        self._products = grown
        self._steps.append(s)
        return s
