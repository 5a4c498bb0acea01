"""Claims about when an iteration of Newton's method ends, and the options that say so."""

from types import SimpleNamespace

from petsc4py import PETSc

import numpy as np
import pytest

from turbine_fenicsx._compat import NOT_A_NUMBER
from turbine_fenicsx.time_stepping.convergence import DIVERGENCE, BlockwiseConvergence
from turbine_fenicsx.time_stepping.solver_options import SolverOptions


def ends(residuals, round_off=0.0, approximate=False):
    """PETSc's reason after the first residual that ends the iteration, and how many there were."""
    current = [0.0]
    step = SimpleNamespace(
        system=SimpleNamespace(flexible_models=()),
        relative_residuals=lambda R, beyond: np.full(4, max(current[0] - round_off * beyond, 0.0)),
    )
    chosen = SolverOptions(tolerance=1e-6, max_iterations=20)
    convergence = BlockwiseConvergence(step, chosen)
    convergence.start_iteration(approximate)
    snes = SimpleNamespace(getFunction=lambda: [None])
    for iteration, residual in enumerate(residuals):
        current[0] = residual
        reason = convergence(snes, iteration, None)
        if reason:
            return reason, iteration
    return 0, iteration


REASONS = PETSc.SNES.ConvergedReason


def test_an_iteration_ends_at_round_off_once_a_step_gains_little():
    """Below the estimate a gain of a factor of fifty is still taken, one of twenty is not."""
    falling = [1.0, 1e-2, 2e-4, 4e-6, 2e-7, 1e-9]
    assert ends(falling) == (REASONS.CONVERGED_FNORM_RELATIVE, 5)
    assert ends(falling, round_off=1e-5) == (REASONS.CONVERGED_SNORM_RELATIVE, 4)


def test_an_approximate_tangent_ends_at_round_off_once_nothing_is_gained():
    """Its residual falls by a digit per step on the way: that is no sign of round-off."""
    falling = [1.0, 1e-1, 1e-3, 1e-4, 6e-6, 5e-6, 1e-7]
    assert ends(falling, round_off=1e-3, approximate=True) == (REASONS.CONVERGED_SNORM_RELATIVE, 5)
    assert ends(falling, round_off=1e-3)[1] == 3


def test_an_iteration_that_grows_is_given_up():
    growing = [1e-3, 1e-2, 0.5 * DIVERGENCE * 1e-3, 2.0 * DIVERGENCE * 1e-3]
    assert ends(growing) == (REASONS.DIVERGED_DTOL, 3)
    assert ends(growing[:3]) == (0, 2)
    assert ends([1.0] * 30)[0] == REASONS.DIVERGED_MAX_IT
    assert ends([1.0, np.nan])[0] == NOT_A_NUMBER


@pytest.mark.parametrize(
    ("residuals", "keeps"),
    [
        ([1e4], True),  # of an earlier step
        ([1e4, 101.0], False),
        ([1e4, 99.0], True),
        ([1e4, 1e3, 10.0], True),
        ([1e4, 10.0, 9.0], False),
        ([1e4, np.nan], False),
    ],
)
def test_a_tangent_is_kept_where_one_more_iteration_like_the_last_will_do(residuals, keeps):
    step = SimpleNamespace(system=SimpleNamespace(flexible_models=()))
    convergence = BlockwiseConvergence(step, SolverOptions())
    convergence.history[:] = residuals
    assert convergence.keeps_tangent is keeps


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-12, 2.0, float("nan")])
def test_the_tolerance_must_lie_between_zero_and_one(tolerance):
    with pytest.raises(ValueError, match=f"tolerance must lie between 0 and 1, got {tolerance}"):
        SolverOptions(tolerance=tolerance)


def test_an_unknown_linear_solver_is_refused_with_the_names_there_are():
    with pytest.raises(ValueError, match=r"must be one of \[.*'lu', 'monolithic'.*got 'magic'"):
        SolverOptions(linear_solver="magic")
