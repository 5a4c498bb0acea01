"""The tables of controller, drivetrain, yaw and events: mistakes, unused keys, files."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from case_mistakes import mistakes

from turbine_fenicsx.case.files import list_files
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.description import describe_case
from turbine_fenicsx.turbine.tables.control import ControlCase
from turbine_fenicsx.turbine.tables.event import list_events

RIGID = {"turbine": {"model": "rigid"}, "pitch": {"drive": "actuator"}}


def parse(**tables):
    return Case.parse(RIGID | tables)


def test_defaults_are_those_of_the_nrel_5_mw_turbine():
    """NREL/TP-500-38060, tables 7-1 and 7-2 and the values of its controller."""
    c = ControlCase()
    assert np.isclose(c.torque.make().torque(1173.7 * pi / 30.0), 43093.55, rtol=1e-5)
    assert np.isclose(c.pitch.gain_angle * 180.0 / pi, 6.302336, rtol=1e-6)
    assert np.isclose(c.pitch.rate * 180.0 / pi, 8.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        (
            {"control": {"kind": "pid"}},
            'control.kind = \'pid\': expected "none", "pi", "discon" or "python:FILE:CLASS"',
        ),
        (
            {"control": {"kind": "python:mine.py"}},
            'control.kind = \'python:mine.py\': expected "none", "pi", "discon" or '
            '"python:FILE:CLASS"',
        ),
        (
            {"control": {"kind": "pi"}, "pitch": {"drive": "free"}},
            'control.kind = "pi": expected pitch.drive = "actuator", got "free"',
        ),
        (
            {"control": {"kind": "pi"}, "turbine": {"model": "hybrid"}},
            'control.kind = "pi": expected pitch.bearings = true, a controller turns the blades',
        ),
        (
            {"control": {"kind": "discon"}},
            'control.kind = "discon": expected control.library, the name of a file',
        ),
        (
            {"control": {"kind": "discon", "library": "/no/lib.so", "input": "/no/DISCON.IN"}},
            "control.library = '/no/lib.so': there is no such file",
        ),
        (
            {"control": {"kind": "python:/no/mine.py:Mine"}},
            "control.kind = \"python:/no/mine.py:Mine\": there is no file '/no/mine.py'",
        ),
        (
            {"control": {"kind": "pi", "torque": {"cut_in_speed": 100.0}}},
            "control.torque: speeds of the torque law must rise from cut-in to optimal to rated, "
            "got 100, 91.2109 and 121.68 rad/s",
        ),
        (
            {"control": {"kind": "pi", "pitch": {"largest": "-1 deg"}}},
            "control.pitch: largest pitch of the pitch law must be above the fine pitch 0 rad, got "
            "-0.0174533 rad",
        ),
        (
            {"control": {"kind": "pi", "torque": {"rated_power": "5 MN"}}},
            "control.torque.rated_power = '5 MN': expected a power, for example \"5 MW\"; a bare "
            "number counts in W",
        ),
        (
            {"drivetrain": {"model": "stiff"}},
            "drivetrain.generator_inertia = 0: expected more than 0 with drivetrain.model = "
            '"stiff"',
        ),
        (
            {"drivetrain": {"model": "two_mass", "generator_inertia": 500.0}},
            'drivetrain.stiffness = 0: expected more than 0 with drivetrain.model = "two_mass"',
        ),
        (
            {"drivetrain": {"efficiency": 1.01}},
            "drivetrain.efficiency = 1.01: must be less than or equal to 1",
        ),
        (
            {"event": {"stop": {"kind": "shut_down"}}, "pitch": {"drive": "free"}},
            'event.stop.kind = "shut_down": expected pitch.drive = "actuator"',
        ),
        (
            {"event": {"hold": {"kind": "brake", "time": 3}}},
            'event.hold.kind = "brake": expected drivetrain.brake_torque greater than 0',
        ),
        (
            {"event": {"stop": {"kind": "pitch_fault", "blade": 4}}},
            "event.stop.blade = 4: must be 1, 2 or 3",
        ),
        (
            {"event": {"first stop": {}}},
            "event: expected names of letters, digits and _ that begin with a letter, got "
            "'first stop'",
        ),
    ],
)
def test_mistakes_are_sentences(tables, sentence):
    found = mistakes(RIGID | tables)
    assert [line for line in found if line == sentence] == [sentence], found


def test_keys_without_effect_are_told():
    case = parse(
        control={"kind": "pi", "library": "x.so"},
        event={"stop": {"kind": "grid_loss", "rate": "3 deg/s", "time": 99}},
        drivetrain={"stiffness": 1e8, "brake_torque": 1e6},
        yaw={"drive": "lock"},
        loads={"yaw_torque": 1e3},
    )
    assert case.warnings == [
        'drivetrain.stiffness has no effect with drivetrain.model = "none"',
        'drivetrain.brake_torque has no effect without an event of kind "brake"',
        'control.library has no effect with control.kind = "pi"',
        'event.stop.rate has no effect with event.stop.kind = "grid_loss"',
        'loads.yaw_torque has no effect with yaw.drive = "lock"',
        "event.stop.time = 99 s is after time.end = 12 s, so it does not happen",
    ]


def test_events_of_a_list_have_names_too(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'turbine.model = "rigid"\npitch.drive = "actuator"\n'
        '[[event]]\nkind = "grid_loss"\ntime = "2 s"\n'
        '[[event]]\nkind = "shut_down"\ntime = "1 s"\n'
    )
    case = Case.load(path, ["event.event_1.time=3"])
    assert [(e.kind, e.time) for e in list_events(case.event)] == [
        ("shut_down", 1.0),
        ("grid_loss", 3.0),
    ]
    assert mistakes({**RIGID, "event": [{"kind": "storm"}]})[0].startswith(
        "event.event_1.kind = 'storm': must be 'start_up', "
    )
    assert mistakes({**RIGID, "event": 3}) == ["event = 3: must be a table"]


def test_files_stand_beside_the_case(tmp_path):
    (tmp_path / "mine.py").write_text("class Mine: ...")
    path = tmp_path / "case.toml"
    path.write_text(
        'turbine.model = "rigid"\npitch.drive = "actuator"\n'
        '[control]\nkind = "python:mine.py:Mine"\nlibrary = "lib.so"\n'
    )
    case = Case.load(path)
    assert case.control.python_class == (tmp_path / "mine.py", "Mine")
    assert case.control.library == str(tmp_path / "lib.so")
    assert [(mark.what, name) for mark, name in list_files(case.model_dump(), Case)] == [
        ("controller", str(tmp_path / "mine.py")),
        ("library of the controller", str(tmp_path / "lib.so")),
    ]
    assert Case.parse(case.model_dump(mode="json")) == case


def test_events_have_names_that_overrides_know(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'turbine.model = "rigid"\npitch.drive = "actuator"\n'
        '[event.stop]\nkind = "emergency_stop"\ntime = "30 s"\n'
        '[event.grid]\nkind = "grid_loss"\ntime = "20 s"\n'
    )
    case = Case.load(path, ["event.stop.rate=4 deg/s", "event.grid.time=25"])
    grid, stop = list_events(case.event)
    assert (grid.kind, grid.time) == ("grid_loss", 25.0)
    assert np.isclose(stop.rate, 4.0 * pi / 180.0) and np.isclose(stop.pitch, 0.5 * pi)
    shown = describe_case(case.model_dump(mode="json"))
    assert shown["event"]["grid"] == {"kind": "grid_loss", "time_[s]": 25.0}
    assert Path(path).exists()
