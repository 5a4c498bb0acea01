"""Claims about wind that is steady, and about the transients of IEC 61400-1."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.gusts import (
    CoherentGust,
    DirectionChange,
    OperatingGust,
    TurbineClass,
    WindShear,
)
from turbine_fenicsx.wind.inflow import SteadyWind

HUB = np.array([0.0, 0.0, 100.0])
GIVEN = {"speed": 12.0, "hub_height": 100.0, "diameter": 120.0, "start": 5.0}
SIGMA = 0.14 * (0.75 * 12.0 + 5.6)  # class B
REDUCED = SIGMA / (1.0 + 0.1 * 120.0 / 42.0)


def test_wind_grows_over_height_by_the_power_law_and_rests_below_the_ground():
    wind = SteadyWind(10.0, 100.0, shear=0.2)
    places = np.array([[5.0, -3.0, 200.0], [0, 0, 100.0], [0, 0, 25.0], [0, 0, -1.0]])
    expected = 10.0 * np.array([2.0**0.2, 1.0, 0.25**0.2, 0.0])
    assert wind.velocity(places, 3.0) == pytest.approx(expected[:, None] * [1.0, 0.0, 0.0])


def test_wind_comes_from_a_direction_and_an_inclination():
    wind = SteadyWind(10.0, direction=np.radians(90.0), inclination=np.radians(30.0))
    expected = 10.0 * np.array([0.0, np.cos(np.pi / 6), 0.5])
    assert wind.velocity(HUB, 0.0) == pytest.approx(expected, abs=1e-14)


def test_the_operating_gust_dips_and_rises_as_in_the_standard():
    gust = OperatingGust(**GIVEN)
    assert gust.amplitude == pytest.approx(3.3 * REDUCED)
    times = np.linspace(5.0, 15.5, 10001)
    along = np.array([gust.velocity(HUB, t)[0] for t in times])
    s = (times - 5.0) / 10.5
    expected = 12.0 - 0.37 * gust.amplitude * np.sin(3 * np.pi * s) * (1 - np.cos(2 * np.pi * s))
    assert along == pytest.approx(expected)
    assert np.argmax(along) == 5000 and along[5000] == pytest.approx(12.0 + 0.74 * gust.amplitude)
    assert gust.velocity(HUB, 0.0)[0] == gust.velocity(HUB, 20.0)[0] == 12.0


def test_near_the_highest_speed_of_a_year_the_gust_is_limited_by_it():
    gust = OperatingGust(**{**GIVEN, "speed": 44.0}, turbine_class=TurbineClass("I", "A+"))
    assert gust.amplitude == pytest.approx(1.35 * (0.8 * 1.4 * 50.0 - 44.0))


@pytest.mark.parametrize("sign", [1, -1])
def test_the_direction_changes_and_stays(sign):
    turn = DirectionChange(**GIVEN, sign=sign)
    theta = 4.0 * np.arctan(REDUCED / 12.0)
    for time, part in ((0.0, 0.0), (8.0, 0.5), (11.0, 1.0), (99.0, 1.0)):
        angle = sign * part * theta
        expected = 12.0 * np.array([np.cos(angle), np.sin(angle), 0.0])
        assert turn.velocity(HUB, time) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("speed", "degrees"), [(3.9, 180.0), (12.0, 60.0)])
def test_the_coherent_gust_rises_by_15_metres_per_second_and_turns(speed, degrees):
    gust = CoherentGust(**{**GIVEN, "speed": speed})
    angle = np.radians(degrees)
    expected = (speed + 15.0) * np.array([np.cos(angle), np.sin(angle), 0.0])
    assert gust.velocity(HUB, 15.0) == pytest.approx(expected, abs=1e-12)
    halfway = gust.velocity(HUB, 10.0)
    assert np.linalg.norm(halfway) == pytest.approx(speed + 7.5)


@pytest.mark.parametrize("horizontal", [False, True])
def test_the_extreme_shear_is_largest_at_the_edge_of_the_rotor_and_passes(horizontal):
    shear = WindShear(**GIVEN, horizontal=horizontal)
    edge = HUB + 60.0 * (np.array([0, 1.0, 0]) if horizontal else np.array([0, 0, 1.0]))
    steady = shear.velocity(edge, 0.0)
    change = (shear.velocity(edge, 11.0) - steady)[0]
    assert change == pytest.approx(2.5 + 0.2 * 6.4 * SIGMA * (120.0 / 42.0) ** 0.25)
    assert shear.velocity(edge, 17.0) == pytest.approx(steady)
    assert shear.velocity(HUB, 11.0) == pytest.approx([12.0, 0.0, 0.0])


def test_a_turned_wind_has_its_horizontal_shear_across_it():
    shear = WindShear(**GIVEN, horizontal=True, direction=np.radians(90.0))
    left = HUB - [60.0, 0.0, 0.0]
    assert shear.velocity(left, 11.0)[1] > 14.0


def test_extreme_turbulence_of_class_one_b():
    # c = 2 m/s, V_ave = 10 m/s
    expected = 2.0 * 0.14 * (0.072 * (5.0 + 3.0) * (6.0 - 4.0) + 10.0)
    assert TurbineClass("I", "B").extreme_deviation(12.0) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SteadyWind(-1.0), "wind speed must not be negative, got -1.0"),
        (lambda: SteadyWind(9.0, shear=np.inf), "shear of the wind must not be negative, got inf"),
        (lambda: TurbineClass("IV"), "class of the turbine must be one of 'I', 'II', 'III'"),
        (
            lambda: OperatingGust(**{**GIVEN, "diameter": 0.0}),
            "diameter of a gust must be positive",
        ),
    ],
)
def test_winds_that_cannot_be_are_refused(make, words):
    with pytest.raises(ModelError, match=words):
        make()
