"""Claims about steady rotors: against CCBlade, published tables and closed forms."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosco_blades import iea_blade, nrel_blade, without_moments

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.polar import Polar
from turbine_fenicsx.wind.resampling import place_stations, resample_blade
from turbine_fenicsx.wind.rotor import (
    Operation,
    Rotor,
    find_performance,
    find_pitch,
    find_section_loads,
)

HERE = Path(__file__).parent
CCBLADE = json.loads((HERE / "ccblade.json").read_text())
ANGLES = np.radians(np.linspace(-180.0, 180.0, 721))


def thin_blade(n=60, tip_speed_ratio=8.0, lift=1.0, blades=3, design=None):
    """The rotor of optimum shape at a tip speed ratio: wake rotation, no drag, no losses."""
    radius = np.linspace(5.0, 99.9, n)
    ratio = tip_speed_ratio * radius / 100.0
    phi = 2.0 / 3.0 * np.arctan(1.0 / ratio)
    chord = 8.0 * np.pi * radius / (blades * lift) * (1.0 - np.cos(phi))
    polar = Polar("flat", ANGLES, 2.0 * np.pi * np.sin(ANGLES), 0.0 * ANGLES, 0.0 * ANGLES)
    twist = phi - np.arcsin(lift / (2.0 * np.pi))
    return AeroBlade(4.0, 100.0, radius, chord, twist, (polar,) * n)


@pytest.mark.parametrize("name", CCBLADE)
def test_line_loads_are_those_of_ccblade(name):
    case = CCBLADE[name]
    blade = replace(nrel_blade() if name.startswith("nrel") else iea_blade(), prebend=None)
    assert blade.radius == pytest.approx(case["r"], abs=1e-5)
    operation = Operation(
        case["wind_speed"], case["rotor_speed_rad_s"], np.radians(case["pitch_deg"])
    )
    loads = find_section_loads(Rotor(blade), operation, np.zeros(1))
    for found, key in ((loads.normal, "normal_N_per_m"), (loads.tangential, "tangential_N_per_m")):
        expected = np.array(case[key])
        assert np.max(np.abs(found[0] - expected)) <= 1e-7 * np.max(np.abs(expected))


@pytest.mark.parametrize("row", json.loads((HERE / "iea15_performance.json").read_text())[4::9])
def test_iea_15_takes_the_power_and_thrust_of_its_published_table(row):
    rotor = Rotor(without_moments(iea_blade()), 3, np.radians(4.0), np.radians(6.0), 150.0)
    speed = row["rpm"] * np.pi / 30.0
    operation = Operation(row["V"], speed, np.radians(row["pitch"]), shear=0.2)
    found = find_performance(rotor, operation)
    assert found.power_coefficient == pytest.approx(row["Cp_aero"], rel=0.02)
    assert found.thrust_coefficient == pytest.approx(row["Ct"], rel=0.03)


@pytest.mark.parametrize(
    ("wind", "pitch"), [(12.0, 3.83), (15.0, 10.45), (18.0, 14.92), (20.0, 17.47), (22.0, 19.94)]
)
def test_nrel_5_mw_is_held_at_rated_power_by_its_published_pitch(wind, pitch):
    rotor = Rotor(without_moments(nrel_blade()), precone=np.radians(2.5))
    operation = Operation(wind, 12.1 * np.pi / 30.0)
    found = find_pitch(rotor, operation, 5.2966e6, (np.radians(pitch - 3.0), np.radians(pitch + 3)))
    assert np.degrees(found) == pytest.approx(pitch, abs=0.1)


@pytest.mark.parametrize(
    ("name", "wind", "rpm", "pitch"),
    [("nrel", 8.0, 9.2, 0.0), ("nrel", 12.0, 12.1, 4.0), ("iea", 8.0, 5.7, 0.0)],
)
def test_few_stations_of_a_quadrature_give_power_and_thrust(name, wind, rpm, pitch):
    own = {"nrel": nrel_blade, "iea": iea_blade}[name]()
    operation = Operation(wind, rpm * np.pi / 30.0, np.radians(pitch))
    found = []
    for count in (16, 1000):
        radius, lengths = place_stations(own.hub_radius, own.tip_radius, count)
        blade = replace(resample_blade(own, radius), lengths=lengths)
        rotor = Rotor(blade, precone=np.radians(2.5), hub_height=150.0)
        found.append(find_performance(rotor, operation, sectors=1))
    few, many = found
    assert few.power == pytest.approx(many.power, rel=1.5e-3)
    assert few.thrust == pytest.approx(many.thrust, rel=1.5e-3)


def test_an_optimum_rotor_of_many_blades_comes_close_to_the_limit_with_wake_rotation():
    # with 300 blades losses are at the very ends; Glauert's optimum at a tip speed ratio of 8
    blade = thin_blade(n=200, blades=300)
    found = find_performance(Rotor(blade, 300), Operation(10.0, 0.8), sectors=1)
    assert found.power_coefficient == pytest.approx(0.5785, rel=0.01)
    assert found.power_coefficient < 16.0 / 27.0


def test_an_ideal_rotor_that_turns_fast_comes_to_the_limit_of_betz():
    # the rotation of the wake fades with the tip speed ratio, losses with the number of blades
    found = []
    for ratio, blades in ((8.0, 300), (20.0, 1000), (60.0, 10000)):
        blade = thin_blade(n=400, tip_speed_ratio=ratio, blades=blades)
        rotor, operation = Rotor(blade, blades), Operation(10.0, 0.1 * ratio)
        found.append(find_performance(rotor, operation, sectors=1).power_coefficient)
    assert found[0] < found[1] < found[2] < 16.0 / 27.0
    # the hub takes 4 and 5 of 100 m: 0.25 % of the area does not work
    assert found[2] == pytest.approx(16.0 / 27.0, rel=4e-3)


def test_in_the_optimum_the_wind_is_slowed_as_glauert_found():
    blade = thin_blade(n=200, blades=300)
    loads = find_section_loads(Rotor(blade, 300), Operation(10.0, 0.8), np.zeros(1))
    for k in range(60, 190, 10):
        x = 8.0 * blade.radius[k] / 100.0
        roots = np.roots([16.0, -24.0, 9.0 - 3.0 * x * x, x * x - 1.0])
        (expected,) = (a.real for a in roots if 0.25 < a.real < 1.0 / 3.0)
        assert loads.induction.axial[0, k] == pytest.approx(expected, rel=2e-4)


def test_a_coned_and_tilted_rotor_faces_less_wind():
    blade = thin_blade()
    straight = find_performance(Rotor(blade), Operation(10.0, 0.8))
    tilted = find_performance(Rotor(blade, tilt=np.radians(6.0)), Operation(10.0, 0.8))
    coned = find_performance(Rotor(blade, precone=np.radians(6.0)), Operation(10.0, 0.8))
    for other in (tilted, coned):
        assert 0.95 * straight.power < other.power < straight.power


def test_prebend_that_undoes_precone_leaves_a_flat_rotor_but_for_its_radius():
    blade, cone = thin_blade(), np.radians(4.0)
    bent = replace(blade, prebend=blade.radius * np.tan(cone))
    flat = find_section_loads(Rotor(blade), Operation(10.0, 0.8), np.zeros(1))
    # the sections face the wind; they are 1/cos(cone) further out
    found = find_section_loads(
        Rotor(bent, precone=cone), Operation(10.0, 0.8 * np.cos(cone)), np.zeros(1)
    )
    assert found.normal == pytest.approx(flat.normal, rel=1e-12)


def test_shear_loads_the_upper_blade_more_and_yaw_one_side():
    rotor, up_and_down = Rotor(thin_blade(), hub_height=130.0), np.array([0.0, np.pi])
    sheared = find_section_loads(rotor, Operation(10.0, 0.8, shear=0.2), up_and_down)
    assert np.all(sheared.normal[0, 10:] > sheared.normal[1, 10:])
    yawed = Operation(10.0, 0.8, yaw=np.radians(20.0))
    # wind from -y to y: the blade that points up moves to -y, against it
    loads = find_section_loads(rotor, yawed, up_and_down)
    assert np.all(loads.normal[0, 30:] > loads.normal[1, 30:])


def test_a_pitch_that_cannot_give_a_power_is_refused():
    with pytest.raises(ModelError, match="no pitch between 0 and 5 degrees gives 500 MW at 10 m/s"):
        find_pitch(Rotor(thin_blade()), Operation(10.0, 0.8), 5e8, (0.0, np.radians(5.0)))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"wind_speed": 0.0}, "wind speed of an operation must be positive, got 0.0"),
        ({"density": -1.0}, "density of an operation must be positive, got -1.0"),
        ({"pitch": np.nan}, "pitch of an operation must be a number, got nan"),
    ],
)
def test_operations_that_cannot_be_are_refused(change, words):
    with pytest.raises(ModelError, match=words):
        Operation(**{"wind_speed": 10.0, "rotor_speed": 1.0, **change})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"blades": 0}, "a rotor needs at least one blade, got 0"),
        ({"tilt": 2.0}, "tilt of the rotor must be below 90 degrees"),
        ({"hub_height": -3.0}, "hub height of the rotor must be positive"),
    ],
)
def test_rotors_that_cannot_be_are_refused(change, words):
    with pytest.raises(ModelError, match=words):
        Rotor(thin_blade(), **change)


def test_tips_below_the_ground_are_refused():
    with pytest.raises(
        ModelError, match="the tips reach the ground: they are 100 m from the shaft"
    ):
        find_performance(Rotor(thin_blade(), hub_height=90.0), Operation(10.0, 0.8))


def storm_rotor():
    """The IEA 15 MW rotor at a dozen stations."""
    own = iea_blade()
    radius, lengths = place_stations(own.hub_radius, own.tip_radius, 12)
    blade = replace(resample_blade(own, radius), lengths=lengths)
    return Rotor(blade, 3, np.radians(4.0), np.radians(6.0), 150.0)


@pytest.mark.parametrize("wind", [12.0, 47.5])
@pytest.mark.parametrize(
    ("key", "first", "last"),
    [("rotor_speed", 0.0, 1.0), ("pitch", 0.0, np.pi / 2.0), ("yaw", -0.7, 0.7)],
)
def test_loads_are_continuous_from_standstill_on(key, first, last, wind):
    rotor = storm_rotor()
    values = np.linspace(first, last, 129)
    for speed, pitch in ((0.0, 1.55), (0.05, 1.5), (0.5, 0.5), (1.0, 0.0)):
        given = {"wind_speed": wind, "rotor_speed": speed, "pitch": pitch, "yaw": -0.03}
        found = np.array(
            [find_performance(rotor, Operation(**{**given, key: x}), 2)[:2] for x in values]
        )
        coarse, fine = (np.max(np.abs(np.diff(x, axis=0)), axis=0) for x in (found[::4], found))
        # steps a quarter as long change a continuous function less; kinks of polars may spoil some
        assert np.all(fine <= 0.5 * coarse)


@pytest.mark.parametrize("speed", [0.0, 0.05, 0.3, 0.7])
def test_no_parked_or_idling_rotor_has_more_thrust_than_its_blades_can_have(speed):
    rotor = storm_rotor()
    for yaw in np.radians(np.arange(-180.0, 180.0, 15.0)):
        for pitch in np.radians([0.0, 45.0, 88.0]):
            operation = Operation(50.0, speed, pitch, yaw)
            assert abs(find_performance(rotor, operation).thrust_coefficient) < 0.2
            induction = find_section_loads(rotor, operation, np.zeros(1)).induction
            assert np.all(np.abs(induction.axial) <= 1.0)


def test_a_rotor_without_induction_has_the_loads_of_its_blade_elements():
    rotor = replace(storm_rotor(), induction=False)
    found = find_section_loads(rotor, Operation(10.0, 0.75), np.zeros(1)).induction
    assert not np.any(found.axial) and not np.any(found.tangential)
