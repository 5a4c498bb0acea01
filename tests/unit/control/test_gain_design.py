"""Claims about gains that follow from the aerodynamics of a rotor."""

from dataclasses import replace

import numpy as np
import pytest
from rosco_blades import nrel_blade

from turbine_fenicsx import ModelError
from turbine_fenicsx.control.gain_design import (
    RatedPoint,
    find_pitch_gains,
    find_sensitivity,
    find_torque_gain,
)
from turbine_fenicsx.control.pi import PitchLaw
from turbine_fenicsx.control.torque_law import TorqueLaw
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance

RATED = RatedPoint(speed=12.1 * np.pi / 30.0, power=5.29661e6, fine=0.0)
INERTIA = 43_784_725.0
"""Of the NREL 5 MW turbine's drivetrain about the slow shaft, NREL/TP-500-38060, section 7.3."""


@pytest.fixture(scope="module")
def rotor():
    return Rotor(nrel_blade(), precone=np.radians(2.5), hub_height=90.0)


def test_gains_of_the_nrel_5_mw_turbine_are_those_of_its_report(rotor):
    """Section 7.3: 0.6 rad/s, damping 0.7; K_P, K_I and the angle of half gains."""
    found = find_pitch_gains(rotor, RATED, INERTIA, 97.0, frequency=0.6, damping=0.7)
    published = PitchLaw()
    assert found.proportional == pytest.approx(published.proportional_gain, rel=0.03)
    assert found.integral == pytest.approx(published.integral_gain, rel=0.03)
    assert found.angle == pytest.approx(published.gain_angle, rel=0.1)


def test_the_best_torque_of_the_nrel_5_mw_turbine_is_that_of_its_report(rotor):
    """Section 7.2: tip-speed ratio 7.55."""
    K = find_torque_gain(rotor, RATED, 7.55) / 97.0**3
    assert TorqueLaw().gain == pytest.approx(K, rel=0.03)


def test_power_changes_more_while_the_wake_stays(rotor):
    at = Operation(12.0, RATED.speed, pitch=np.radians(4.0))
    turned = replace(at, pitch=at.pitch + 0.01)
    before, frozen, settled = (
        find_performance(rotor, operation, 1, wake=wake).power
        for operation, wake in ((at, None), (turned, at), (turned, None))
    )
    assert find_performance(rotor, at, 1, wake=at).power == before
    # less induction gives back a part of what the pitch takes
    assert frozen < settled < before


def test_each_wind_above_rated_has_its_pitch_and_its_slope(rotor):
    theta, slope = find_sensitivity(rotor, RATED)
    assert np.all(np.diff(theta) > 0.0) and np.all(np.diff(slope) < 0.0)
    assert 0.0 < theta[0] < np.radians(4.0)
    assert np.degrees(theta[-1]) == pytest.approx(23.47, abs=0.3)  # at 25 m/s, table 7-1


def test_gains_fall_with_the_ratio_and_grow_with_inertia_and_frequency(rotor):
    base = find_pitch_gains(rotor, RATED, INERTIA)
    geared = find_pitch_gains(rotor, RATED, 2.0 * INERTIA, 50.0, frequency=0.4)
    assert geared.proportional == pytest.approx(base.proportional * 2.0 * 2.0 / 50.0)
    assert geared.integral == pytest.approx(base.integral * 2.0 * 4.0 / 50.0)


def test_a_rotor_that_does_not_reach_its_power_is_refused(rotor):
    with pytest.raises(ModelError, match=r"does not reach 60 MW at 1\.267 rad/s"):
        find_pitch_gains(rotor, replace(RATED, power=6e7), INERTIA)
