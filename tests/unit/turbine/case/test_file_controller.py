"""Claims about the built-in controller with the values of a windIO file."""

import numpy as np
import pytest
from case_mistakes import mistakes
from windio_files import IEA_15, IEA_22, find_turbine, small_turbine, write_turbine

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_control import find_inertia
from turbine_fenicsx.turbine.case.turbine_file import describe_file, load_turbine

RPM = np.pi / 30.0
PI = {"control": {"kind": "pi"}}


def case(name=IEA_15, **tables):
    return Case.parse({"turbine": {"file": str(find_turbine(name))}, **PI, **tables})


def test_speeds_limits_and_rates_are_those_of_the_file():
    c, pitch = case().control, case().pitch
    assert c.filter_frequency == 1.0081
    assert c.torque.cut_in_speed == pytest.approx(5.0 * RPM, rel=1e-4)
    assert c.torque.rated_power == 15e6
    assert c.torque.largest == 21765400.0
    assert c.torque.rate == 4.5e6
    assert c.pitch.speed == pytest.approx(7.56 * RPM, rel=1e-4)
    assert c.pitch.rate == pytest.approx(np.radians(2.0), rel=1e-3)
    assert c.pitch.largest == pytest.approx(np.radians(89.95), rel=1e-3)
    assert (pitch.bearings, pitch.drive, pitch.frequency) == (True, "actuator", 3.14)


def test_a_case_with_rigid_blades_leaves_the_next_one_its_pitch_bearings():
    case(turbine={"file": str(find_turbine(IEA_15)), "model": "rigid"})
    assert case().pitch.bearings


def test_gains_are_near_those_chosen_by_hand():
    """Those chosen by hand for demos/iea15_gust are 2.2 s, 0.23 and 4 degrees."""
    pitch = case().control.pitch
    assert pitch.proportional_gain / pitch.integral_gain == pytest.approx(2.0 * 1.0 / 0.2)
    assert 1.5 < pitch.proportional_gain < 2.2
    assert np.degrees(pitch.gain_angle) == pytest.approx(4.3, abs=0.3)


@pytest.mark.parametrize("name", [IEA_15, IEA_22])
def test_region_2_ends_below_rated_speed_and_torque(name):
    law = case(name).control.torque.make()
    assert law.optimal_speed < law.transition_speed < law.rated_speed
    assert law.gain * law.rated_speed**2 < law.rated_power / law.rated_speed < law.largest


def test_the_inertia_of_the_rotor_is_that_of_its_blades():
    turbine = load_turbine(str(find_turbine(IEA_15)))
    sections = turbine.blade_sections
    z = turbine.blade.outer_shape.axis[2].smooth(sections.grid)
    r = (z + turbine.hub.radius) * np.cos(np.radians(turbine.hub.cone_angle))
    m = 0.5 * (sections.inertia[1:, 0, 0] + sections.inertia[:-1, 0, 0]) * np.diff(z)
    middle = 0.5 * (r[1:] + r[:-1])
    expected = 3.0 * m @ middle**2 + turbine.hub.body.inertia[0, 0]
    assert find_inertia(turbine) == pytest.approx(expected, rel=0.01)
    assert find_inertia(turbine) == pytest.approx(3.36e8, rel=0.01)


def test_speeds_and_torques_count_on_the_shaft_of_the_generator():
    slow, fast = case().control, case(drivetrain={"ratio": 50, "efficiency": "0.9"}).control
    assert fast.pitch.speed == pytest.approx(50.0 * slow.pitch.speed)
    assert fast.pitch.integral_gain == pytest.approx(slow.pitch.integral_gain / 50.0, rel=0.1)
    assert fast.torque.rated_power == pytest.approx(15e6 / 0.9)
    law = fast.torque.make()
    rated = law.rated_power / law.rated_speed
    assert rated == pytest.approx(15e6 / 0.9 / (0.99 * 7.56 * RPM * 50.0), rel=1e-4)
    assert law.gain * law.rated_speed**2 < rated


def test_the_case_overrides_single_values():
    given = case(control={"kind": "pi", "pitch": {"fine": "1 deg"}}, pitch={"frequency": 5})
    assert given.control.pitch.fine == pytest.approx(np.radians(1.0))
    assert given.control.pitch.rate == case().control.pitch.rate
    assert (given.pitch.frequency, given.pitch.drive) == (5.0, "actuator")
    lines = describe_file(given)
    assert "control.torque.gain" in lines[1] and "control.pitch.fine" not in lines[1]
    assert lines[2] == "overridden by the case: control.pitch.fine, pitch.frequency"


def test_without_the_built_in_controller_nothing_of_it_is_taken():
    plain = Case.parse({"turbine": {"file": str(find_turbine(IEA_15))}})
    assert not plain.pitch.bearings
    assert "control" not in " ".join(describe_file(plain))


def test_controllers_of_others_turn_the_blades_by_the_drives_of_the_file(tmp_path):
    (tmp_path / "mine.py").write_text("class Mine: pass\n")
    turbine = {"file": str(find_turbine(IEA_22))}
    kind = f"python:{tmp_path / 'mine.py'}:Mine"
    found, own = Case.parse({"turbine": turbine, "control": {"kind": kind}}), case(IEA_22)
    assert (found.pitch, found.drivetrain.ratio) == (own.pitch, own.drivetrain.ratio)
    assert (found.pitch.bearings, found.pitch.drive) == (True, "actuator")
    assert np.degrees(found.pitch.initial) == pytest.approx(-4.0, abs=0.5)
    assert found.control.torque == Case.parse({}).control.torque
    lines = describe_file(found)
    assert "pitch.bearings" in lines[1] and "control.torque" not in lines[1]
    # nothing about bearings where something else is wrong
    assert mistakes({"turbine": turbine, "control": {"kind": "discon"}}) == [
        'control.kind = "discon": expected control.library, the name of a file'
    ]


def test_what_a_file_lacks_is_said(tmp_path):
    path = str(write_turbine(small_turbine(), tmp_path))
    tables = {"turbine": {"file": path}, "pitch": {"bearings": True, "drive": "actuator"}, **PI}
    assert mistakes(tables) == [
        'control.kind = "pi": expected the tables control.torque and control.pitch, which do not '
        "follow from 'small.yaml': it has no control.rated_rotor_speed"
    ]
    own = {"kind": "pi", "torque": {"slip": 0.2}, "pitch": {"fine": 0.0}}
    assert Case.parse({**tables, "control": own}).control.torque.slip == 0.2


def test_a_rotor_without_polars_has_no_gains(tmp_path):
    turbine = small_turbine()
    turbine["control"] = {"rated_rotor_speed": 10.0, "rated_power": 1e9, "optimal_tsr": 8.0}
    path = str(write_turbine(turbine, tmp_path))
    tables = {"turbine": {"file": path}, **PI}
    (found,) = mistakes(tables)
    assert "follow from 'small.yaml': " in found
    turbine["control"]["max_pitch_rate"] = -1.0
    write_turbine(turbine, tmp_path)
    found = mistakes(tables)
    assert any("small.yaml: control.max_pitch_rate must lie at or above 0, got" in x for x in found)
