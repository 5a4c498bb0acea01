"""Fits of vibrations that steps of the midpoint rule have changed."""

import numpy as np
import pytest

from turbine_fenicsx.analysis.decay_fit import fit_decay

STEP, S = 0.05, complex(-0.04, 2.6)


def vibrate(turned=0.0):
    """A vibration that the midpoint rule makes of S, seen from a frame that turns."""
    times = STEP * np.arange(400)
    factor = (1.0 + 0.5 * STEP * S) / (1.0 - 0.5 * STEP * S)
    return times, factor ** np.arange(400) * np.exp(-1j * turned * times)


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_what_steps_do_is_undone_where_they_were_made(turned):
    times, q = vibrate(turned)
    guess = 1.03 * (S - 1j * turned)
    found = fit_decay(times, 3.0 * q + 0.01, guess, STEP, turned)
    assert found.eigenvalue == pytest.approx(S - 1j * turned, rel=1e-8)
    assert found.miss < 1e-8
    # left in, they change the decay by a quarter of the square of the angle of a step
    change = found.with_steps.real / S.real - 1.0
    assert change == pytest.approx(-((S.imag * STEP) ** 2) / 4.0, rel=0.02)


def test_without_a_step_nothing_is_undone():
    times, q = vibrate()
    found = fit_decay(times, q, S)
    assert found.eigenvalue == found.with_steps
    assert abs(found.with_steps / S - 1.0) > 1e-3
