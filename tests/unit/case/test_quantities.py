"""Claims about numbers with units."""

import pytest
from case_mistakes import mistakes

from turbine_fenicsx.case.quantities import to_si
from turbine_fenicsx.turbine.case.case import Case


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("45 GPa", "Pa", 45e9),
        ("36000 kN m", "N m", 3.6e7),
        ("-36000 kN m", "N m", -3.6e7),
        ("-36 MN*m", "N m", -3.6e7),
        ("20 ms", "s", 0.02),
        ("0.2 min", "s", 12.0),
        ("54 m", "m", 54.0),
        ("180 cm", "m", 1.8),
        ("165 t", "kg", 165e3),
        ("1.5 g/cm^3", "kg/m^3", 1500.0),
        ("9.81 m/s^2", "m/s^2", 9.81),
        ("9.81 m/s**2", "m/s^2", 9.81),
        ("1e5 kg m^2", "kg m^2", 1e5),
        ("3 kg m²", "kg m^2", 3.0),
        ("12s", "s", 12.0),
        ("7.2 km/h/s", "m/s^2", 2.0),
        ("1 psi", "Pa", 6894.757293168361),
        ("5 uPa", "Pa", 5e-6),
        ("180 deg", "rad", 3.141592653589793),
        ("12 rpm", "rad/s", 1.2566370614359172),
        ("1.2 rad/s", "rad/s", 1.2),
        ("-90 deg/s", "rad/s", -1.5707963267948966),
        ("50 MN m", "N m/rad", 5e7),
        ("50 MN m/rad", "N m/rad", 5e7),
        ("1 kN m/deg", "N m/rad", 57295.77951308232),
        ("3 kN m s/rad", "N m s/rad", 3e3),
        ("0.02", "s", 0.02),  # a bare number in quotes is a bare number
        (0.02, "s", 0.02),
        (3, "s", 3),
    ],
)
def test_numbers_with_units_become_si(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["3 kg", "3 N", "fast", "3 parsnips", "", "3 s s"])
def test_anything_but_a_time_is_no_time(text):
    (sentence,) = mistakes({"time": {"step": text}})
    assert sentence.startswith(f"time.step = {text!r}: expected a time, for example ")


@pytest.mark.parametrize(
    "text",
    ["1,5 s", "1.500,0 s", "s", "12 s ; 3", "2*3 s", "12 s 3", "1_0", "3 s^", "1 s*9**9**9**9**9"],
)
def test_text_that_is_not_one_number_and_one_unit_is_refused(text):
    # "1,5 s" is read as 15 s
    assert mistakes({"time": {"step": text}})


@pytest.mark.parametrize("text", ["0.2 Hz", "12 rad", "12 1/min"])
def test_a_speed_of_rotation_is_not_taken_for_a_frequency(text):
    """0.2 Hz would be 1.26 rad/s for one reader and 0.2 for the other."""
    assert mistakes({"turbine": {"rotor_speed": text}}) == [
        f'turbine.rotor_speed = {text!r}: expected a speed of rotation, for example "12 rpm"; a '
        "bare number counts in rad/s"
    ]


def test_a_case_with_units_equals_the_same_case_in_bare_si():
    named = {
        "time": {"step": "20 ms", "end": "12 s"},
        "turbine": {"blade_arm": "29.25 m", "hub_distance": "500 cm"},
        "blade": {"length": "0.054 km", "chord": ["1.8 m", "300 cm", "0.6 m"]},
        "mesh": {"size": "50 cm"},
        "material": {"young": ["45 GPa", "15 GPa", "15 GPa"], "density": "1.5 g/cm^3"},
        "loads": {"rotor_torque": "-36000 kN m", "gravity": "9.81 m/s^2", "duration": "3 s"},
        "output": {"fields_every": "100 ms"},
    }
    bare = {
        "time": {"step": 0.02, "end": 12},
        "turbine": {"blade_arm": 29.25, "hub_distance": 5.0},
        "blade": {"length": 54.0, "chord": [1.8, 3.0, 0.6]},
        "mesh": {"size": 0.5},
        "material": {"young": [45e9, 15e9, 15e9], "density": 1500.0},
        "loads": {"rotor_torque": -3.6e7, "gravity": 9.81, "duration": 3.0},
        "output": {"fields_every": 0.1},
    }
    a, b = Case.parse(named).model_dump(), Case.parse(bare).model_dump()
    assert a.keys() == b.keys()
    for section in bare:
        for key, value in bare[section].items():
            # a change of unit rounds once or twice
            assert a[section][key] == pytest.approx(b[section][key], rel=1e-15)
            assert b[section][key] == pytest.approx(value, rel=0.0)
