"""Claims about what is said of a case: bearings, damping, wind."""

import pytest
from aero_files import write_aerodyn

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.description import describe_bearings
from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics

RIGID = {"model": "rigid"}
BEARINGS = {"bearings": True}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({}, "yaw turns freely; blades fixed to the hub without pitch bearings; rotor starts"),
        ({"yaw": {"drive": "lock"}}, "yaw is locked"),
        ({"yaw": {"drive": "drive"}}, "yaw turns at the rate that the controller commands"),
        ({"pitch": BEARINGS}, "pitch turns freely from 0 deg on"),
        (
            {"pitch": BEARINGS | {"drive": "prescribed", "initial": "20 deg"}},
            "pitch locked at 20 deg",
        ),
        (
            {"pitch": BEARINGS | {"drive": "lock", "initial": ["20 deg", "90 deg", "20 deg"]}},
            "pitch locked at 20, 90, 20 deg",
        ),
        (
            {"pitch": BEARINGS | {"drive": "prescribed", "angle": "90 deg", "start": 2.0}},
            "pitch from 0 deg by 90 deg within 5 s from 2 s on",
        ),
        ({"pitch": BEARINGS | {"drive": "spring", "damping": 1.0}}, "pitch on springs about 0 deg"),
        ({"pitch": BEARINGS | {"drive": "actuator"}}, "pitch starts at 0 deg and follows commands"),
        (
            {"turbine": {"rotor_speed": "12 rpm"}, "generator": {"keeps": "speed"}},
            "rotor kept at 12 rpm",
        ),
        ({"turbine": {"rotor_speed": "9 rpm"}}, "rotor starts at 9 rpm and turns freely"),
    ],
)
def test_bearings_are_described(data, words):
    assert words in describe_bearings(Case.parse(data))[0]


@pytest.mark.parametrize(
    ("data", "line"),
    [
        ({}, "structural damping: none"),
        (
            {"blade": {"damping": 0.005}, "tower": {"flexible": True, "damping": "1 %"}},
            "structural damping: blades 0.5 % of flap_1 and edge_1, "
            "tower 1 % of fore_aft_1 and fore_aft_2",
        ),
        (
            {"blade": {"damping": {"flap_1": 0.01, "edge_1": 0.02}}},
            "structural damping: blades 1 % of flap_1, 2 % of edge_1",
        ),
        (
            {"blade": {"damping": {"flap_1": 0.01, "edge_1": 0.01, "speed": "7 rpm"}}},
            "structural damping: blades 1 % of flap_1 and edge_1, at 7 rpm",
        ),
        (
            {"blade": {"damping": {"flap_1": 0.01}}},
            "structural damping: blades 1 % of flap_1, others in proportion to their frequencies",
        ),
        ({"blade": {"damping": {"speed": "7 rpm"}}}, "structural damping: none"),
        (
            {"blade": {"damping": {"stiffness_time": 0.003}}},
            "structural damping: blades in proportion to the stiffness, 0.003 s",
        ),
        (
            {"material": {"shear_viscosity": 1e6}},
            "structural damping: blades by the viscosities of [material]",
        ),
        (
            {"turbine": {"numerical_dissipation": 0.1}},
            "structural damping: numerical dissipation 0.1",
        ),
    ],
)
def test_damping_is_described(data, line):
    assert describe_bearings(Case.parse(data))[1] == line


def test_a_rigid_turbine_has_no_structure_to_damp():
    assert len(describe_bearings(Case.parse({"turbine": RIGID}))) == 1


@pytest.mark.parametrize(
    ("wind", "words"),
    [
        ({"direction": "30 deg"}, "30 deg from the axis of the nacelle"),
        ({"inclination": "8 deg"}, "8 deg upwards"),
        ({"gust": "EOG", "gust_start": 5.0}, "EOG of class IB from 5 s on"),
        (
            {"gust": "EDC", "turbine_class": "IIA+"},
            "EDC of class IIA+ from 0 s on",
        ),
    ],
)
def test_the_wind_is_described(wind, words, tmp_path):
    aero = {"file": str(write_aerodyn(tmp_path))}
    case = Case.parse({"turbine": RIGID, "wind": {"speed": 9.0, **wind}, "aero": aero})
    assert words in describe_aerodynamics(case)[0]


STORM = {"turbine": RIGID, "wind": {"speed": 50.0}}
WORDS = "wind.speed = 50 m/s is above 25 m/s, where turbines stop"


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({}, f"{WORDS} with their blades at some 90 deg of pitch; here they have 0 deg"),
        ({"pitch": {"drive": "prescribed", "initial": "88 deg"}}, None),
        ({"pitch": {"drive": "prescribed", "angle": "90 deg"}}, None),
    ],
)
def test_blades_in_a_storm_are_feathered(more, expected, tmp_path):
    aero = {"file": str(write_aerodyn(tmp_path))}
    found = [w for w in Case.parse(STORM | {"aero": aero} | more).warnings if WORDS in w]
    assert found == ([expected] if expected else [])


@pytest.mark.parametrize("stops", [True, False])
def test_no_controller_works_in_a_storm(stops, tmp_path):
    control = {
        "control": {"kind": f"python:{tmp_path / 'own.py'}:Own"},
        "pitch": {"drive": "actuator"},
        "aero": {"file": str(write_aerodyn(tmp_path))},
    }
    (tmp_path / "own.py").write_text("class Own: pass\n")
    event = {"event": {"stop": {"kind": "shut_down", "time": 1.0}}} if stops else {}
    found = [w for w in Case.parse(STORM | control | event).warnings if WORDS in w]
    assert found == ([] if stops else [f"{WORDS}: the controller works on"])


def test_the_warning_is_silent_below(tmp_path):
    aero = {"file": str(write_aerodyn(tmp_path))}
    case = Case.parse({"turbine": RIGID, "wind": {"speed": 24.0}, "aero": aero})
    assert not any("turbines stop" in w for w in case.warnings)
