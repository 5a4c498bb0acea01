"""Claims about dynamic inflow: the two filters in closed form."""

import numpy as np
import pytest

from turbine_fenicsx.wind.wake import Wake

RADIUS, R, V, A = np.array([20.0, 50.0]), 60.0, 10.0, np.array([0.2, 0.3])
TAU_1 = 1.1 / (1.0 - 1.3 * A) * R / V
TAU_2 = (0.39 - 0.26 * (RADIUS / R) ** 2) * TAU_1
OLD, NEW = np.array([[2.0, 0.5], [3.0, 0.2]]), np.array([[3.0, 0.4], [1.0, 0.3]])


def after(time, steps):
    """The wake a time after its loads have changed all at once."""
    wake, dt = Wake.in_balance(OLD), time / steps
    for _ in range(steps):
        wake = wake.advance(NEW, dt, A, RADIUS, R, V)
    return wake


def test_a_wake_in_balance_stays_so():
    wake = Wake.in_balance(OLD).advance(OLD, 0.3, A, RADIUS, R, V)
    assert wake.velocity == pytest.approx(OLD, rel=1e-14)


def test_after_a_sudden_change_it_follows_two_exponentials():
    # y jumps by 0.6 of the change, then closes the gap with tau_1; w follows y with tau_2
    t = 4.0
    gap = 0.4 * (OLD - NEW)
    slow, fast = np.exp(-t / TAU_1)[:, None], np.exp(-t / TAU_2)[:, None]
    k = (TAU_1 / (TAU_1 - TAU_2))[:, None]
    # w' tau_2 + w = NEW + gap e^{-t/tau_1}, w(0) = OLD
    expected = NEW + gap * k * slow + (OLD - NEW - gap * k) * fast
    assert after(t, 4000).velocity == pytest.approx(expected, rel=1e-3)
    errors = [np.max(np.abs(after(t, n).velocity - expected)) for n in (100, 200)]
    assert errors[1] < 0.6 * errors[0]  # of first order


def test_it_comes_to_the_new_balance():
    assert after(300.0, 3000).velocity == pytest.approx(NEW, rel=1e-9)


def test_stations_beyond_the_tip_follow_as_fast_as_the_tip():
    """A rotor that bends upwind has stations whose radius is larger than R; tau_2 would vanish."""
    old, new, a = np.zeros((3, 2)), np.ones((3, 2)), np.full(3, 0.2)
    radius = np.array([1.0, 1.05, 1.3]) * R
    wake = Wake.in_balance(old).advance(new, 0.5, a, radius, R, V)
    assert np.array_equal(wake.velocity, np.broadcast_to(wake.velocity[0], (3, 2)))
    assert 0.0 < wake.velocity[0, 0] < 1.0


def test_it_can_be_saved():
    wake = after(1.0, 10)
    again = Wake.restore(wake.save())
    assert np.array_equal(
        again.advance(OLD, 0.1, A, RADIUS, R, V).velocity,
        wake.advance(OLD, 0.1, A, RADIUS, R, V).velocity,
    )
