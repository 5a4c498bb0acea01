"""The page on modes of what turns: all of its rows, and what its closed forms mean."""

import numpy as np
import pytest

pytest.importorskip("slepc4py")


@pytest.mark.slow
def test_all_rows_hold(published):
    rows = published.load("turning_modes").main()
    assert {row.quantity: row.error for row in rows if not row.holds} == {}
    assert len(rows) == len(published.references("turning_modes")) == 9


def test_closed_forms(published):
    exact = published.load("turning_modes", "exact")
    # x = 1.875, 4.694 of every handbook, and Wright et al. at a speed of 12
    assert exact.beam(0.0)[:2] == pytest.approx(np.square([1.87510407, 4.69409113]), rel=1e-7)
    assert exact.beam(12.0)[:2] == pytest.approx([13.1702, 37.6031], rel=1e-5)
    # without moments of inertia a mass on a spring 3 E I/L^3; without rotation no whirl is faster
    slow = exact.disc(0.0, 2.0, 10.0, 1e12, 4.0, 1e-9, 0.0)
    assert slow[2] == pytest.approx(np.sqrt(3.0 * 10.0 / 8.0 / 4.0), rel=1e-6)
    assert slow == pytest.approx(-slow[::-1], rel=1e-9)
    # a fast disc keeps its direction: 12 E I/L^3
    fast = exact.disc(1e9, 2.0, 10.0, 1e12, 4.0, 1.0, 2.0)
    assert np.sort(np.abs(fast))[1:3] == pytest.approx([np.sqrt(12.0 * 10.0 / 8.0 / 4.0)] * 2)
