"""Torque law and PI controller against the published values of the NREL 5 MW turbine."""

import numpy as np
import pytest
from scipy.signal import lsim

from turbine_fenicsx import ModelError
from turbine_fenicsx.control.interface import Measurements
from turbine_fenicsx.control.pi import PIController, PitchLaw
from turbine_fenicsx.control.torque_law import TorqueLaw

RATED = 122.9096
LAW = TorqueLaw()


def measure(time, speed, pitch=0.0, first=False, dt=0.05):
    return Measurements(time, dt, first, speed, speed / 97.0, 0.0, (pitch,) * 3, 0.0, 0.0)


def test_regions_join_and_hold_the_published_values():
    """NREL/TP-500-38060: rated torque 43.09 kN m at 1173.7 rpm, cut in at 670 rpm."""
    for speed in (LAW.cut_in_speed, LAW.optimal_speed, LAW.transition_speed, LAW.rated_speed):
        below, above = (LAW.torque(speed * (1.0 + s)) for s in (-1e-9, 1e-9))
        assert abs(above - below) < 2.0  # N m; the steepest line has 3.9 kN m s/rad
    assert abs(LAW.torque(RATED) - 43093.55) < 1.0
    assert LAW.torque(670.0 * np.pi / 30.0) == 0.0
    assert abs(LAW.torque(100.0) - 2.332287 * 100.0**2) < 1e-9
    assert abs(LAW.transition_speed - 119.0137) < 1e-3  # 1136.5 rpm
    assert LAW.torque(110.0, above_rated=True) == LAW.largest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"optimal_speed": 60.0}, "must rise from cut-in to optimal to rated"),
        ({"gain": -1.0}, "gain of the torque law must be positive"),
        ({"gain": 5.0}, "region 2 of the torque law has no end"),
    ],
)
def test_wrong_laws_are_refused(changes, message):
    with pytest.raises(ModelError, match=message):
        TorqueLaw(**changes)
    with pytest.raises(ModelError, match="must be above the fine pitch"):
        PitchLaw(largest=-0.1)


def test_steady_state_is_kept_from_the_first_call_on():
    controller = PIController()
    for k in range(100):
        commands = controller.command(measure(0.05 * k, RATED, 0.26, k == 0))
    assert np.allclose(commands.pitch, 0.26, rtol=0.0, atol=1e-14)
    assert np.isclose(commands.generator_torque, 5.29661e6 / RATED, rtol=1e-12)


@pytest.mark.parametrize("pitch", [0.0, 0.15])
def test_small_changes_follow_the_linear_equations(pitch):
    dt, e, controller = 0.002, 1e-4, PIController()
    A, B, C = controller.linearise(RATED, pitch)
    times = dt * np.arange(4000)
    speeds = e * np.sin(1.3 * times)
    rows = [
        controller.command(measure(t, RATED + w, pitch, k == 0, dt))
        for k, (t, w) in enumerate(zip(times, speeds, strict=True))
    ]
    found = np.array([[row.generator_torque, row.pitch[0]] for row in rows]) - [
        LAW.torque(RATED),
        pitch,
    ]
    _, linear, _ = lsim((A, B[:, None], C, np.zeros((2, 1))), speeds, times)
    # at the fine pitch the integral of a falling speed is cut off, and only the torque is linear
    for column in (0, 1) if pitch else (0,):
        miss = np.max(np.abs(found[:, column] - linear[:, column]))
        assert miss < 0.01 * np.max(np.abs(linear[:, column]))
    assert np.any(C[1]) == (pitch > 0.0)


def test_a_small_error_of_speed_turns_the_blades_by_the_scheduled_gains():
    pitch, e, dt = 0.1099965, 1e-6, 0.05  # where gains are half
    controller = PIController(filter_frequency=1e6)
    controller.command(measure(0.0, RATED, pitch, True))
    found = controller.command(measure(dt, RATED + e, pitch)).pitch[0] - pitch
    assert np.isclose(found, 0.5 * e * (0.01882681 + 0.008068634 * dt), rtol=1e-6)


def test_the_integral_does_not_wind_up():
    controller = PIController(filter_frequency=1e6)
    controller.command(measure(0.0, 100.0, 0.0, True))
    for k in range(1, 2001):  # 100 s far below rated
        controller.command(measure(0.05 * k, 100.0))
    moved = [controller.command(measure(100.0 + 0.05 * k, RATED + 2.0)).pitch[0] for k in range(3)]
    assert moved[0] > 0.9 * 0.05 * 0.1396263  # at once, not after 100 s
    assert np.all(np.diff(moved) > 0.0)


def test_pitch_and_torque_keep_their_rates():
    controller = PIController(filter_frequency=1e6)
    first = controller.command(measure(0.0, 100.0, 0.0, True))
    then = controller.command(measure(0.05, 200.0))
    assert np.isclose(then.pitch[0], 0.05 * 0.1396263)
    assert np.isclose(then.generator_torque - first.generator_torque, 0.05 * 15000.0)


def test_it_goes_on_from_its_states():
    speeds = RATED + np.sin(np.arange(40.0))
    one, other = PIController(), PIController()
    for k, speed in enumerate(speeds):
        commands = one.command(measure(0.05 * k, speed, 0.1, k == 0))
        if k == 20:
            other.restore(one.save())
        elif k > 20:
            assert other.command(measure(0.05 * k, speed, 0.1)) == commands
