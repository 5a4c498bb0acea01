"""Claims about functions of time."""

import numpy as np
import pytest

from turbine_fenicsx.time_functions import Constant, Hat


def test_hat_rises_to_its_peak_at_half_the_duration_and_falls_back():
    hat = Hat(-3.6e7, 3.0)
    assert hat(1.5) == -3.6e7
    for t in (0.3, 0.75, 1.2):
        assert hat(t) == pytest.approx(-3.6e7 * t / 1.5, rel=1e-15)
        assert hat(3.0 - t) == pytest.approx(hat(t), rel=1e-14)


def test_hat_is_exactly_zero_outside_its_duration():
    hat = Hat(2.0, 3.0)
    assert [hat(t) for t in (-1.0, -1e-9, 0.0, 3.0, 3.0 + 1e-9, 1e6)] == [0.0] * 6


def test_area_under_the_hat_is_half_peak_times_duration():
    t = (np.arange(3000) + 0.5) * 1e-3  # midpoint rule, exact as the kink lies on the grid
    assert sum(map(Hat(4.0, 3.0), t)) * 1e-3 == pytest.approx(6.0, rel=1e-13)


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan")])
def test_duration_of_a_hat_must_be_positive(duration):
    with pytest.raises(ValueError, match=f"duration of a hat function .* got {duration} s"):
        Hat(1.0, duration)


def test_constant_is_the_same_at_all_times():
    assert {Constant(2.5)(t) for t in (-1.0, 0.0, 1e9)} == {2.5}
