"""Claims about the strain that is expected at the end of a step."""

import numpy as np
import pytest

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.time_stepping.reduced_step import StrainHistory

DT = 0.1


def after(values, dt=DT):
    """A history whose steps began with some values."""
    history = StrainHistory()
    for k, value in enumerate(values):
        history.start_step(StepTimes.from_start(k * dt, dt), np.array([value]))
    return history


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([3.0], 3.0),
        ([3.0, 3.0], 3.0),
        ([1.0, -1.0], 1.0),
        ([1.0, -1.0, 1.0], -1.0),  # what the midpoint rule makes of stiff modes
        ([5.0, 7.0, 9.0], 11.0),
        ([5.0 + 1.0, 7.0 - 1.0, 9.0 + 1.0], 11.0 - 1.0),
    ],
)
def test_what_is_smooth_or_alternates_is_expected_exactly(values, expected):
    assert after(values).expect() == pytest.approx([expected])


def test_a_step_of_another_length_knows_only_its_start():
    history = after([1.0, 2.0, 3.0])
    history.start_step(StepTimes.from_start(3 * DT, 0.5 * DT), np.array([4.0]))
    assert history.expect() == pytest.approx([4.0])


def test_a_repeated_step_leaves_no_trace():
    history = after([5.0, 7.0, 9.0])
    history.start_step(StepTimes.from_start(2 * DT, DT), np.array([9.0]))
    assert history.expect() == pytest.approx([11.0])


def test_it_continues_where_it_was_saved():
    other = StrainHistory()
    other.restore(*after([5.0, 7.0]).save())
    other.start_step(StepTimes.from_start(2 * DT, DT), np.array([9.0]))
    assert other.expect() == pytest.approx([11.0])
