"""Claims about loads of return periods: those of known distributions, with honest confidence."""

from math import log

import numpy as np
import pytest

from turbine_fenicsx.load_sets.extrapolation import TEN_MINUTES, extrapolate

YEAR = 365.25 * 24 * 3600
PERIOD = 50 * YEAR
MINUTE = 60.0


def exact(mu, beta, shares, n, probability):
    """By bisection on the sum of the distributions."""
    low, high = -1e3, 1e3
    for _ in range(200):
        x = 0.5 * (low + high)
        parts = [1 - np.exp(-n * np.exp(-(x - m) / b)) for m, b in zip(mu, beta, strict=True)]
        low, high = (x, high) if np.dot(shares, parts) > probability else (low, x)
    return x


def perfect(mu, beta, number=20000):
    """Values of Gumbel's distribution at the middles of equal probabilities."""
    p = (np.arange(number) + 0.5) / number
    return (mu - beta * np.log(-np.log(p)))[:, None]


def test_one_speed_has_the_closed_form():
    (found,) = extrapolate([perfect(3.0, 0.5)], [1.0], MINUTE, [PERIOD])
    probability = TEN_MINUTES / PERIOD
    closed = 3.0 - 0.5 * log(-np.log1p(-probability) / 10.0)
    assert found.loads[0] == pytest.approx(closed, rel=1e-3)
    assert found.low[0] < closed < found.high[0]


def test_speeds_count_by_their_shares():
    mu, beta, shares = [3.0, 5.0, 2.0], [0.5, 0.2, 0.4], [0.7, 0.29, 0.01]
    blocks = [perfect(m, b) for m, b in zip(mu, beta, strict=True)]
    for block in (MINUTE, TEN_MINUTES):
        periods = [10 * 86400.0, YEAR, PERIOD]
        found = extrapolate(blocks, shares, block, periods)
        for each, period in zip(found, periods, strict=True):
            n, p = TEN_MINUTES / block, TEN_MINUTES / period
            assert each.loads[0] == pytest.approx(exact(mu, beta, shares, n, p), rel=2e-3)


def test_limits_enclose_the_load_as_often_as_they_say():
    """Columns are samples of ten minutes; nine in ten of their limits hold the load."""
    random = np.random.default_rng(5)
    mu, beta, shares = [3.0, 5.0], [0.5, 0.8], [0.6, 0.4]
    blocks = [m + b * random.gumbel(size=(10, 400)) for m, b in zip(mu, beta, strict=True)]
    (found,) = extrapolate(blocks, shares, MINUTE, [PERIOD])
    true = exact(mu, beta, shares, 10.0, TEN_MINUTES / PERIOD)
    inside = np.mean((found.low < true) & (true < found.high))
    assert 0.85 <= inside <= 0.96
    assert np.median(found.loads) == pytest.approx(true, rel=0.03)


def test_loads_do_not_depend_on_unit_and_origin():
    values = np.random.default_rng(1).gumbel(size=(30, 1))
    (plain,) = extrapolate([values], [1.0], MINUTE, [PERIOD])
    (other,) = extrapolate([1e6 * values - 3e7], [1.0], MINUTE, [PERIOD])
    for name in ("loads", "low", "high"):
        scaled = 1e6 * getattr(plain, name) - 3e7
        assert getattr(other, name) == pytest.approx(scaled, rel=1e-9)


def test_a_speed_at_which_a_load_rests_is_none_the_worse():
    values = np.random.default_rng(1).gumbel(size=(30, 1))
    (alone,) = extrapolate([values], [1.0], MINUTE, [PERIOD])
    (both,) = extrapolate([values, np.zeros((30, 1))], [1.0 - 1e-9, 1e-9], MINUTE, [PERIOD])
    assert both.loads == pytest.approx(alone.loads, rel=1e-6)
