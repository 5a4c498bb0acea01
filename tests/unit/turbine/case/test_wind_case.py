"""Claims about the tables of wind and aerodynamics in a case."""

import numpy as np
import pytest
from aero_files import write_aerodyn, write_turbsim
from case_mistakes import mistakes

from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import make_inflow
from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics
from turbine_fenicsx.turbine.components.wind import make_aero_models

RIGID = {"model": "rigid"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("aero")


@pytest.fixture(scope="module")
def aerodyn(folder):
    return str(write_aerodyn(folder))


def case(aerodyn, wind, **tables):
    return Case.parse({"turbine": RIGID, "wind": wind, "aero": {"file": aerodyn}, **tables})


def wrong(aerodyn, wind, **tables):
    return mistakes({"turbine": RIGID, "wind": wind, "aero": {"file": aerodyn}, **tables})


def test_without_a_wind_there_is_none():
    plain = Case.parse({})
    assert make_inflow(plain) is None
    assert describe_aerodynamics(plain) == []
    unused = Case.parse({"wind": {"shear": 0.1}, "aero": {"file": "x.dat"}})
    assert unused.warnings == [
        "wind.shear has no effect without wind.speed or wind.file",
        "aero has no effect without wind.speed or wind.file",
    ]


def test_the_wind_blows_along_e3_and_grows_with_the_height(aerodyn):
    wind = make_inflow(case(aerodyn, {"speed": "36 ft/s", "shear": 0.14, "hub_height": "90 m"}))
    V = 36 * 0.3048
    assert wind.velocity(np.zeros(3), 0.0) == pytest.approx(V * E3)
    assert wind.velocity(-45.0 * E2, 0.0) == pytest.approx(V * 0.5**0.14 * E3)
    assert wind.velocity(-91.0 * E2, 0.0) == pytest.approx(np.zeros(3))


def test_the_hub_stands_on_the_tower_unless_its_height_is_given(aerodyn):
    tables = {"tower": {"flexible": True, "height": 85.0}}
    turbine = {**RIGID, "hub_rise": 2.0}
    wind = make_inflow(case(aerodyn, {"speed": 10, "shear": 1.0}, turbine=turbine, **tables))
    assert wind.velocity(2.0 * E2, 0.0) == pytest.approx(10.0 * E3)
    assert wind.velocity(-85.0 * E2, 0.0) == pytest.approx(np.zeros(3))


def test_wind_comes_from_the_side_and_from_below(aerodyn):
    table = {"speed": 10, "direction": "30 deg", "inclination": "8 deg"}
    found = make_inflow(case(aerodyn, table)).velocity(np.zeros(3), 0.0)
    assert found[0] > 0.0 and found[1] > 0.0
    assert np.degrees(np.arctan2(found[0], found[2])) == pytest.approx(30.0)
    assert np.degrees(np.arcsin(found[1] / 10.0)) == pytest.approx(8.0)


def test_wind_sets_in_smoothly(aerodyn):
    wind = make_inflow(case(aerodyn, {"speed": 10, "ramp": "4 s"}))
    found = [wind.velocity(np.zeros(3), t)[2] for t in (0.0, 2.0, 4.0, 9.0)]
    assert found == pytest.approx([0.0, 5.0, 10.0, 10.0])


@pytest.mark.parametrize(
    ("gust", "time", "place", "axis"),
    [
        ("EOG", 5.25, 0.0 * E2, E3),
        ("EDC", 60.0, 0.0 * E2, E1),
        ("ECD", 60.0, 0.0 * E2, E1),
        ("EWSV", 6.0, 40.0 * E2, E3),
        ("EWSH", 6.0, 40.0 * E1, E3),
    ],
)
def test_each_gust_begins_when_it_is_told_to(aerodyn, gust, time, place, axis):
    table = {"speed": 11, "gust": gust, "gust_start": "30 s", "gust_sign": -1}
    if gust == "EOG":
        del table["gust_sign"]
    given = case(aerodyn, table)
    assert given.warnings == []
    wind = make_inflow(given)
    before, early, at = (wind.velocity(place, t) @ axis for t in (0.0, 30.0, 30.0 + time))
    assert early == pytest.approx(before, abs=1e-12)
    change = (at - before) * (1 if gust == "EOG" else -1)
    assert change > 1.0


def test_turbulence_comes_from_a_file(aerodyn, folder):
    path = write_turbsim(folder / "t.bts")
    given = case(aerodyn, {"file": str(path), "hub_height": 90}, time={"end": 20})
    found = make_inflow(given).velocity(np.zeros((40, 3)), 7.0)
    assert found.shape == (40, 3) and 7.0 < found[0, 2] < 13.0
    assert "turbulence of 't.bts'" in describe_aerodynamics(given)[0]


def test_a_check_tells_of_the_aerodynamics(aerodyn):
    table = {"speed": 11, "hub_height": 90, "gust": "EOG", "gust_start": 30}
    wind, aero = describe_aerodynamics(case(aerodyn, table))
    assert wind == "wind of 11 m/s at 90 m above ground, shear 0.2, EOG of class IB from 30 s on"
    assert aero == (
        "aerodynamics of rotor.dat: blade-element momentum theory with dynamic inflow and "
        "shed vorticity, 12 stations from 2.748 to 55.75 m, chords from 1.03 to 3.97 m"
    )


def test_stations_are_those_of_a_quadrature_over_the_span(aerodyn):
    given = case(aerodyn, {"speed": 11}, aero={"file": aerodyn, "stations": 9})
    blade = load_aero_blade(given)
    assert len(load_aero_blade(case(aerodyn, {"speed": 11})).radius) == 12
    assert blade.parts @ blade.radius**17 == pytest.approx((56.25**18 - 2.25**18) / 18.0)
    assert blade.chord == pytest.approx(
        np.interp(blade.radius, [2.25, 56.25], [4.0, 1.0]), abs=1e-4
    )


@pytest.mark.parametrize(
    ("wind", "sentence"),
    [
        ({"speed": -1}, "wind.speed = -1: must be greater than or equal to 0"),
        ({"speed": 1000}, "wind.speed = 1000: must be less than or equal to 200"),
        ({"speed": "10 m"}, "wind.speed = '10 m': expected a speed, for example \"10 m/s\""),
        ({"speed": 8, "density": -1.2}, "wind.density = -1.2: must be greater than 0"),
        ({"speed": 8, "gust_sign": 0}, "wind.gust_sign = 0: expected 1 or -1"),
        ({"speed": 8, "gust": "EWS"}, "wind.gust = 'EWS': must be 'none', 'EOG'"),
        ({"gust": "EOG", "speed": 0}, 'wind.gust = "EOG": expected wind.speed greater than 0'),
        ({"speed": 8, "hub_height": 50}, "wind.hub_height = 50: expected more than 56.25 m"),
        ({"speed": 8, "file": "t.bts"}, "wind.speed = 8: expected none beside wind.file"),
        ({"file": "nowhere.bts"}, "wind.file: cannot read 'nowhere.bts'"),
    ],
)
def test_winds_that_cannot_be_are_refused(aerodyn, wind, sentence):
    found = wrong(aerodyn, wind)
    assert any(line.startswith(sentence) for line in found), found


def test_a_field_too_short_low_and_narrow_is_refused_with_both_sizes(aerodyn, folder):
    path = write_turbsim(folder / "s.bts", duration=10.0, size=80.0, bottom=50.0)
    found = wrong(aerodyn, {"file": str(path), "hub_height": 90}, time={"end": 60})
    assert len(found) == 3
    assert found[0].startswith("wind.file: the wind field lasts 10 s, ")
    assert found[1].endswith("goes from 50 to 130 m above ground, the rotor from 33.75 to 146.25 m")
    assert found[2] == "wind.file: the wind field is 80 m wide, the rotor 112.5 m"


def test_blades_need_aerodynamics_that_fit(aerodyn, folder):
    tables = {"turbine": RIGID, "wind": {"speed": 8}}
    (found,) = mistakes(tables)
    assert found.startswith("aero.file: expected one beside a wind, a primary file of AeroDyn 15")
    (found,) = wrong("nowhere.dat", {"speed": 8})
    assert found.startswith("aero.file: cannot read 'nowhere.dat'")
    (found,) = wrong(aerodyn, {"speed": 8}, blade={"length": 61.5})
    assert found == (
        "aero.file: its blades end at a radius of 56.25 m, those of the case at blade.hub_radius + "
        "blade.length = 63.75 m, expected the same to 1 %"
    )
    half = write_aerodyn(folder / "half", last=170.0)
    (found,) = wrong(str(half), {"speed": 8})
    assert "polar 'round' must go from -180 to 180 degrees, got -180 to 170" in found
    flat = write_aerodyn(folder / "flat", chord=-4.0)
    (found,) = wrong(str(flat), {"speed": 8})
    assert "chords must be positive, got -4 m" in found


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        ("NumAFfiles", "Polars", "is no file of AeroDyn 15: it has no NumAFfiles"),
        ("ADBlFile(1)", "Blade", "names no blade: it has no ADBlFile(1)"),
        ('"plate.dat"', "", "line 5: expected the name of a file, got ''"),
        ('"plate.dat"', '"gone.dat"', "gone.dat"),
        ("  2   Num", "  1   Num", "names polar 2 in column BlAFID, but 1 polars are given"),
    ],
)
def test_primary_files_that_cannot_be_read_are_told_by_line(folder, before, after, sentence):
    path = write_aerodyn(folder / "primary")
    path.write_text(path.read_text().replace(before, after))
    (found,) = wrong(str(path), {"speed": 8})
    assert found.startswith("aero.file: ") and sentence in found


def test_models_of_the_aerodynamics_are_named_and_the_tower_has_its_shape(aerodyn):
    aero = {"file": aerodyn, "dynamic_stall": "oeye", "skewed_wake": True}
    shape = {"flexible": True, "height": 80.0, "bottom_diameter": 6.0, "top_diameter": 4.0}
    given = {"turbine": RIGID, "wind": {"speed": 9.0}, "tower": shape}
    plain = Case.parse({**given, "aero": {"file": aerodyn}})
    assert set(make_aero_models(plain).values()) == {None}
    both = Case.parse({**given, "aero": {**aero, "tower_shadow": "powles", "tower_drag": 0.7}})
    models = make_aero_models(both)
    assert models["stall"].lag == 4.0 and models["skew"].factor > 1.4
    assert models["tower"].drag == 0.7
    # half-way up the radius is 2.5 m; twice as far before the tower a quarter of the wind is gone
    before = models["tower"].disturb(9.0 * E3[None], np.array([[0.0, -40.0, -5.0]]))
    assert before[0] == pytest.approx(0.75 * 9.0 * E3)
    assert (
        "dynamic inflow, dynamic stall, shed vorticity, a skewed wake and the tower's shadow"
        in (describe_aerodynamics(both)[1])
    )
    unused = Case.parse({**given, "aero": {**aero, "tower_shadow": "potential", "tower_drag": 0.7}})
    assert unused.warnings == ['aero.tower_drag has no effect with aero.tower_shadow = "potential"']
    assert make_aero_models(unused)["tower"].drag == 0.0


def test_a_tower_without_a_shape_has_no_shadow(aerodyn):
    aero = {"file": aerodyn, "tower_shadow": "potential"}
    (found,) = mistakes({"turbine": RIGID, "wind": {"speed": 8}, "aero": aero})
    assert 'aero.tower_shadow = "potential": expected tower.flexible = true' in found


def test_a_case_may_leave_induction_out_and_says_so(aerodyn):
    given = {"turbine": RIGID, "wind": {"speed": 9.0}}
    found = Case.parse({**given, "aero": {"file": aerodyn, "induction": False}})
    assert "no induction" in describe_aerodynamics(found)[1]


def test_settings_of_aerodyn_that_have_no_effect_are_told(folder):
    path = write_aerodyn(folder / "settings")
    text = path.read_text()
    given = {"turbine": RIGID, "wind": {"speed": 9.0}, "aero": {"file": str(path)}}
    assert not any("rotor.dat" in w for w in Case.parse(given).warnings)
    path.write_text("0 WakeMod\n1 TwrShadow\n1.1 AirDens\nTrue TipLoss\n" + text)
    (found,) = (w for w in Case.parse(given).warnings if "rotor.dat" in w)
    assert found.startswith("rotor.dat sets WakeMod = 0, TwrShadow = 1, AirDens = 1.1; only")
    given["aero"]["induction"] = False
    (found,) = (w for w in Case.parse(given).warnings if "rotor.dat" in w)
    assert "WakeMod" not in found


def test_a_twist_in_radians_is_asked_about(folder):
    path = write_aerodyn(folder / "radians")
    blade = path.parent / "blade.dat"
    rows = [line.split() for line in blade.read_text().splitlines()]
    for row in rows[6:]:
        row[4] = f"{np.radians(float(row[4])):g}"
    blade.write_text("\n".join(" ".join(row) for row in rows))
    given = {"turbine": RIGID, "wind": {"speed": 9.0}, "aero": {"file": str(path)}}
    (found,) = (w for w in Case.parse(given).warnings if "radians" in w)
    assert "the largest twist in rotor.dat is 0.2" in found
