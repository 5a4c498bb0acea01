"""Drives of pitch and yaw: closed formulas against the differential equation."""

import numpy as np
import pytest

from turbine_fenicsx import ModelError
from turbine_fenicsx.control.drives import PitchDrive, YawDrive


def integrate(w, zeta, target, angle, rate, time, steps=20_000):
    """theta'' + 2 zeta w theta' + w^2 (theta - target) = 0 by Runge-Kutta's method."""

    def slope(y):
        return np.array([y[1], -2.0 * zeta * w * y[1] - w * w * (y[0] - target)])

    y, h = np.array([angle, rate]), time / steps
    for _ in range(steps):
        a = slope(y)
        b = slope(y + 0.5 * h * a)
        c = slope(y + 0.5 * h * b)
        d = slope(y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return y


@pytest.mark.parametrize("zeta", [0.3, 1.0 - 1e-9, 1.0, 1.7])
def test_the_formula_solves_the_equation(zeta):
    drive = PitchDrive(1.0, 6.0, zeta, angle=0.2, rate=-0.1, target=0.5)
    for time in (0.01, 1.3):
        expected = integrate(6.0, zeta, 0.5, 0.2, -0.1, time)
        assert np.allclose(drive.find_motion(time), expected, rtol=0.0, atol=1e-10)


def test_a_new_command_changes_neither_angle_nor_rate():
    drive = PitchDrive(-1.0, 3.0, 0.8, angle=0.1)
    assert drive(5.0) == -0.1  # it stays where it is told to
    drive.hold(0.4, 1.0)
    before = drive.find_motion(1.7)
    drive.hold(-0.2, 1.7)
    assert np.allclose(drive.find_motion(1.7), before, rtol=0.0, atol=1e-15)
    assert abs(drive.find_motion(60.0)[0] + 0.2) < 1e-12


def test_a_drive_goes_on_from_its_state():
    drive = PitchDrive(1.0, 3.0, 0.8)
    drive.hold(0.4, 0.3)
    drive.hold(0.1, 0.7)
    other = PitchDrive(1.0, 3.0, 0.8, angle=9.0)
    other.restore(drive.save())
    assert other(2.0) == drive(2.0)


@pytest.mark.parametrize(("w", "zeta"), [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0)])
def test_drives_without_frequency_or_damping_are_refused(w, zeta):
    with pytest.raises(ModelError, match="of a pitch drive must be positive"):
        PitchDrive(1.0, w, zeta)


def test_yaw_turns_at_the_rate_that_is_held():
    drive = YawDrive(-1.0)
    drive.hold(0.1, 2.0)
    drive.hold(-0.2, 5.0)
    assert np.isclose(drive(6.0), -(0.3 - 0.2))
    other = YawDrive(-1.0)
    other.restore(drive.save())
    assert other(7.0) == drive(7.0)
