"""Claims about averaged polars: slopes are secants, and nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest
from rosco_blades import iea_blade
from turning_rotors import ANGLES, aerodynamics, plain_blade, turning

from turbine_fenicsx.wind.averaged_polar import average, average_polars
from turbine_fenicsx.wind.polar import Polar

HALF = np.radians(0.7)


def corner():
    """Lift whose slope jumps from 6 to 1 at five degrees, and what is linear or constant beside."""
    lift = np.where(ANGLES < np.radians(5.0), 6.0 * ANGLES, 1.0 * ANGLES + 5.0 * np.radians(5.0))
    end = np.abs(ANGLES) > np.radians(170.0)
    return Polar("corner", ANGLES, np.where(end, 0.0, lift), 0.02 + 0.0 * ANGLES, 0.0 * ANGLES)


@pytest.mark.parametrize("polar", [corner(), iea_blade().polars[30]], ids=["corner", "aerofoil"])
def test_slopes_are_secants_of_the_original(polar):
    averaged, h = average(polar, HALF), np.radians(0.1)
    angle = averaged.angle[np.abs(averaged.angle) < np.radians(35.0)]
    i = np.flatnonzero(np.diff(angle) > 0.5 * h)
    a, b = angle[i], angle[i + 1]
    # between two angles of the table the mean of the secants, which are linear there
    slopes = (averaged.coefficients(b) - averaged.coefficients(a)) / (b - a)
    middle = 0.5 * (a + b)
    ends = (polar.coefficients(middle + x) for x in (HALF, -HALF))
    secants = np.subtract(*ends) / (2.0 * HALF)
    assert slopes == pytest.approx(secants, abs=1e-9)


def test_straight_parts_stay_as_they_are_around_the_whole_circle():
    averaged = average(corner(), HALF)
    angle = np.radians([-179.95, -150.0, -2.0, 3.0, 30.0, 150.0, 179.95])
    assert averaged.coefficients(angle) == pytest.approx(corner().coefficients(angle), abs=1e-9)
    at_corner = (
        averaged.coefficients(np.radians(5.0))[0] - corner().coefficients(np.radians(5.0))[0]
    )
    # d/4 of the jump of the slope below the corner
    assert at_corner == pytest.approx(-0.25 * HALF * 5.0, rel=1e-6)


def test_a_rotor_takes_averaged_polars_and_leaves_those_of_its_blade():
    blade = replace(plain_blade(), polars=(corner(),) * 20)
    source, other = aerodynamics(blade), aerodynamics(average_polars(blade, HALF))
    before = source.loads(turning(blade, 0.0), 0.0)[0]
    source.average_polars(HALF)
    after, expected = (each.loads(turning(blade, 0.0), 0.0)[0] for each in (source, other))
    assert np.array_equal(after, expected) and not np.array_equal(after, before)
    assert average_polars(blade, 0.0) is blade
