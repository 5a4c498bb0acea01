"""Claims about the skewed wake: its angle, its mean, and that a yawed rotor is turned back."""

import numpy as np
import pytest
from turning_rotors import CENTRE, SHAFT, aerodynamics, plain_blade, run, turning

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.skew import PITT_PETERS, SkewedWake

AZIMUTHS = 2.0 * np.pi * np.arange(12) / 12.0
OUTWARD = np.stack([0.0 * AZIMUTHS, np.cos(AZIMUTHS), np.sin(AZIMUTHS)], axis=1)
HALF = np.full(12, 0.5)


def factors(wind, induced=0.0, skew=None):
    return (skew or SkewedWake()).find_factors(np.array(wind), SHAFT, induced, OUTWARD, HALF)


def test_a_rotor_that_faces_the_wind_has_no_skew():
    assert np.all(factors((9.0, 0.0, 0.0), 3.0) == 1.0)
    assert np.all(factors((0.0, 0.0, 0.0)) == 1.0)


@pytest.mark.parametrize("induced", [0.0, 3.0])
def test_induction_varies_with_the_tangent_of_half_the_angle_of_the_wake(induced):
    chi = np.arctan2(4.0, 9.0 - induced)
    expected = 1.0 + 15.0 * np.pi / 32.0 * 0.5 * np.tan(0.5 * chi) * np.cos(AZIMUTHS)
    found = factors((9.0, 4.0, 0.0), induced)
    assert found == pytest.approx(expected, rel=1e-14)
    assert found.mean() == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("wind", [(0.0, 9.0, 0.0), (-5.0, 3.0, 3.0)])
def test_induction_never_changes_its_sign(wind):
    found = factors(wind, 2.0, SkewedWake(2.0 * PITT_PETERS))
    assert found.min() >= 0.0 and found.max() <= 2.0


@pytest.mark.parametrize("yaw", [-0.4, 0.4])
def test_a_skewed_wake_turns_a_yawed_rotor_back_into_the_wind(yaw):
    blade = plain_blade()
    wind = SteadyWind(10.0, 150.0, direction=yaw)
    moments = []
    for skew in (None, SkewedWake()):
        source = aerodynamics(blade, wind=wind, skew=skew)
        run(source, blade, 3)
        motion = turning(blade, 0.15)
        thrust = source.loads(motion, 0.15)[0][:, 0]
        # about z, with which the shaft turns from x to y
        moments.append(-np.sum((motion.position - CENTRE)[:, 1] * thrust))
    assert (moments[1] - moments[0]) * np.sign(yaw) > 0.0


def test_a_factor_below_zero_is_refused():
    with pytest.raises(ModelError, match="factor of the skewed wake must not be negative"):
        SkewedWake(-1.0)
