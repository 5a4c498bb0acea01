"""The page on small vibrations: all of its rows, and what its closed forms and its run mean."""

import numpy as np
import pytest
from runs import comm

pytest.importorskip("slepc4py")


def test_all_rows_hold(published):
    rows = published.load("small_vibrations").main(comm)
    assert {row.quantity: row.error for row in rows if not row.holds} == {}
    assert len(rows) == len(published.references("small_vibrations")) == 10


def test_closed_forms(published):
    exact = published.load("small_vibrations", "exact")
    # x = 1.875, 4.694, 7.855, 10.996 of every handbook
    squares = exact.clamped_beam(4, 1.0, 1.0, 1.0) * 2.0 * np.pi
    assert np.sqrt(squares) == pytest.approx([1.87510407, 4.69409113, 7.85475744, 10.99554073])
    # a rod on a hinge at its end
    assert exact.pendulum(1.0, 0.5, 1.0 / 12.0, 9.81) == pytest.approx(
        np.sqrt(1.5 * 9.81) / (2.0 * np.pi)
    )
    # of two equal rods: w^2 l/g = 3 -+ 6/sqrt(7)
    squares = np.square(2.0 * np.pi * exact.double_pendulum(1.0, 1.0))
    assert squares == pytest.approx(3.0 + np.array([-6.0, 6.0]) / np.sqrt(7.0))


def test_the_run_without_the_correction_for_its_step_misses_the_frequency(published):
    """By (w dt)^2/12, 2e-3 here, so that the bound of 1e-3 says something of the correction."""
    run = published.load("small_vibrations")
    assert (2.0 * np.pi / run.STEPS_PER_PERIOD) ** 2 / 12.0 > 2e-3
    assert run.run_error(comm)["run"] <= 1e-4
