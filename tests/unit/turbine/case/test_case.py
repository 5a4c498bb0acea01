"""Claims about case files: units, defaults, overrides, and one sentence for every mistake."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.quantities import to_si

DEMOS = Path(__file__).parents[4] / "demos" / "paper"


def mistakes(data):
    """The sentences about a case given as nested tables."""
    with pytest.raises(InputError) as error:
        Case.parse(data)
    return str(error.value).splitlines()


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


def test_defaults_are_the_paper_with_its_stiff_blades():
    case = Case.parse({})
    assert (case.time.step, case.time.end) == (0.02, 12.0)
    assert (case.turbine.model, case.turbine.angle_form) == ("hybrid", "regular")
    assert case.turbine.blade_arm == "printed"
    # c = 27 + 4.5/(2 cos 30), r4 = (4.5 + 54)/2
    assert case.turbine.parameters().blade_arms == pytest.approx((29.598076, 29.25, 29.598076))
    assert (case.mesh.cell, case.mesh.elements, case.mesh.degree) == ("hexahedron", (2, 2, 12), 1)
    m = case.material
    assert (m.law, m.density, m.young) == ("transversely_isotropic", 1500.0, (45e9, 15e9, 15e9))
    assert (m.shear, m.poisson) == ((5.4e9,) * 3, (0.3,) * 3)
    assert (m.first_lame, m.shear_modulus) == (3.9e9, 0.975e9)


def test_demos_are_valid_and_say_what_the_paper_says():
    rigid, stiff, soft = (
        Case.load(DEMOS / f"{name}.toml") for name in ("rigid", "hybrid_stiff", "hybrid_soft")
    )
    assert [c.turbine.model for c in (rigid, stiff, soft)] == ["rigid", "hybrid", "hybrid"]
    for case in (rigid, stiff, soft):
        assert (case.time.step, case.time.end, case.loads.duration) == (0.02, 12.0, 3.0)
        assert case.loads.rotor_torque == pytest.approx(-3.6e7)
    assert [c.loads.gravity for c in (rigid, stiff, soft)] == [9.81, 9.81, 0.0]
    assert [c.loads.yaw_torque for c in (rigid, stiff)] == [0.0, 0.0]
    assert soft.loads.yaw_torque == pytest.approx(0.1 * soft.loads.rotor_torque)
    assert (stiff.material.law, soft.material.law) == (
        "transversely_isotropic",
        "st_venant_kirchhoff",
    )
    assert stiff.material == Case.parse({}).material


@pytest.mark.parametrize("arm", [29.25, "29.25 m", "2925 cm"])
def test_one_arm_for_all_blades_balances_the_rotor(arm):
    case = Case.parse({"turbine": {"blade_arm": arm}})
    assert case.turbine.parameters().blade_arms == (29.25, 29.25, 29.25)


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("time.step", 0.0, "greater than 0"),
        ("time.step", -0.02, "greater than 0"),
        ("time.step", float("nan"), "expected a time"),
        ("time.step", "inf", "expected a time"),
        ("time.end", -1.0, "greater than or equal to 0"),
        ("time.end", float("inf"), "expected a time"),
        ("material.density", -1500.0, "greater than 0"),
        ("material.density", "-1500 kg/m^3", "greater than 0"),
        ("material.density", "1500 kg", 'expected a density, for example "1500 kg/m^3"'),
        ("material.first_lame", float("nan"), "expected a stress or modulus"),
        ("material.law", "steel", "'st_venant_kirchhoff' or 'neo_hooke'"),
        ("turbine.model", "flexible", "'rigid' or 'hybrid'"),
        ("turbine.angle_form", "other", "'regular' or 'paper'"),
        ("turbine.hub_distance", 0, "greater than 0"),
        ("mesh.cell", "wedge", "'hexahedron' or 'tetrahedron'"),
        ("mesh.degree", 3, "1 or 2"),
        ("mesh.degree", True, "a whole number"),
        ("mesh.file", 3, "must be text in quotes"),
        ("blade.length", "54 s", 'expected a length, for example "2.25 m"'),
        ("blade.stations", [], "fractions of the span that begin with 0 and end with 1"),
        ("blade.stations", [0, 0.5, 0.4, 1], "increasing fractions"),
        ("blade.chord", [1.8, 0.6], "one width for each of the 3 blade.stations, got 2"),
        ("mesh.size", 1e-9, "displacements"),
        ("time.step", 1e-12, "more than 1e+09 steps"),
        ("solver.max_iterations", 10**10, "less than or equal to 100000"),
        ("mesh.size", "0 m", "greater than 0"),
        ("loads.rotor_torque", "3 kN", "a bare number counts in N m"),
        ("loads.duration", 0.0, "greater than 0"),
        ("loads.gravity", "-9.81 m/s^2", "greater than or equal to 0"),
        ("solver.linear_solver", "magic", "'lu' or 'monolithic'"),
        ("solver.tolerance", 0.0, "greater than 0"),
        ("solver.max_iterations", 0, "greater than or equal to 1"),
        ("output.fields_every", -0.1, "greater than or equal to 0"),
        ("loads.pitch_torque", "3 N", "expected a torque"),
        ("pitch.bearings", "yes", "must be true or false"),
        ("tower.flexible", 1, "must be true or false"),
        ("pitch.ring_mass", 0.0, "greater than 0"),
        ("pitch.drive", "motor", "'free', 'spring' or 'prescribed'"),
        ("pitch.stiffness", -1.0, "greater than or equal to 0"),
        ("pitch.stiffness", "3 N/m", 'expected a stiffness against rotation, for example "50 MN'),
        ("pitch.damping", "3 N m/rad", "a bare number counts in N m s/rad"),
        ("pitch.angle", "90 m", 'expected an angle, for example "90 deg"'),
        ("pitch.angle", "400 deg", "less than or equal to 6.28"),
        ("pitch.start", -1.0, "greater than or equal to 0"),
        ("pitch.duration", 0.0, "greater than 0"),
        ("tower.height", 0.0, "greater than 0"),
        ("tower.wall", "-4 cm", "greater than 0"),
        ("tower.degree", 3, "1 or 2"),
        ("tower.young", "210 GN", "expected a stress or modulus"),
        ("tower.young", 0.0, "greater than 0"),
        ("tower.poisson", 0.5, "less than 0.5"),
        ("tower.poisson", -1, "greater than -1"),
        ("tower.top_mass", 0.0, "greater than 0"),
    ],
)
def test_value_out_of_range_is_one_sentence_with_key_value_and_range(key, value, text):
    section, name = key.split(".")
    (sentence,) = mistakes({section: {name: value}})
    shown = tuple(map(float, value)) if isinstance(value, list) else value
    assert sentence.startswith(f"{key} = {shown!r}: ")
    assert text in sentence


@pytest.mark.parametrize(
    ("elements", "key"),
    [
        ([2, 2], "mesh.elements"),
        ([2, 2, 12, 1], "mesh.elements"),
        ([2, 2, 0], "mesh.elements.2"),
        ([2, 2, 10**9], "mesh.elements.2"),
        ([100000, 100000, 100000], "mesh.elements"),
        ([2.5, 2, 12], "mesh.elements.0"),
        ("many", "mesh.elements"),
    ],
)
def test_elements_are_three_whole_numbers_from_one(elements, key):
    (sentence,) = mistakes({"mesh": {"elements": elements}})
    assert sentence.startswith(key)


@pytest.mark.parametrize(
    "material",
    [
        {"poisson": [0.9, 0.9, 0.9]},
        {"young": [45e9, -15e9, 15e9]},
        {"shear": ["5.4 GPa", "0 GPa", "5.4 GPa"]},
        {"law": "st_venant_kirchhoff", "shear_modulus": -1.0},
        {"law": "st_venant_kirchhoff", "first_lame": -1e9, "shear_modulus": 1e9},
        {"law": "neo_hooke", "shear_modulus": 0.0},
    ],
)
def test_material_that_is_not_positive_definite_is_refused(material):
    (sentence,) = mistakes({"material": material})
    assert sentence.startswith("material")
    assert "not positive definite" in sentence


def test_constants_of_other_laws_do_not_matter():
    # the Lame constants are negative, but the law does not use them
    Case.parse({"material": {"first_lame": -1.0, "shear_modulus": -1.0}})
    Case.parse({"material": {"law": "neo_hooke", "poisson": [0.9, 0.9, 0.9]}})


@pytest.mark.parametrize("name", ["young", "shear", "poisson"])
@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_constants_that_are_no_numbers_are_refused(name, wrong):
    (sentence,) = mistakes({"material": {name: [wrong, 0.3, 0.3]}})
    assert sentence.startswith(f"material.{name}")


def test_true_is_no_number():
    assert mistakes({"time": {"step": True}})


@pytest.mark.parametrize("arm", [-1.0, "5 kg"])
def test_wrong_arm_is_told_that_metres_are_allowed(arm):
    (sentence,) = mistakes({"turbine": {"blade_arm": arm}})
    assert 'expected "printed" or a length greater than 0' in sentence


@pytest.mark.parametrize(
    ("data", "key", "hint"),
    [
        ({"materail": {}}, "materail", "did you mean 'material'?"),
        (
            {"solver": {"preconditioner": "lu"}},
            "solver.preconditioner",
            "it is called 'solver.linear_solver' now",
        ),
        ({"time": {"stop": 1.0}}, "time.stop", "did you mean 'time.step'?"),
        ({"material": {"densty": 1.0}}, "material.densty", "did you mean 'material.density'?"),
        (
            {"loads": {"rotortorque": 1.0}},
            "loads.rotortorque",
            "did you mean 'loads.rotor_torque'?",
        ),
        ({"turbine": {"hub": {"mas": 1.0}}}, "turbine.hub.mas", "'turbine.hub.mass'?"),
        ({"mesh": {"wxyzwxyz": 1}}, "mesh.wxyzwxyz", "[mesh] takes cell, degree, elements, file"),
        ({"qqq": 1}, "qqq", "a case file takes blade, loads, material, mesh, output"),
        ({"loads": {"step": 1.0}}, "loads.step", "did you mean 'time.step'?"),
        ({"step": 1.0}, "step", "did you mean 'time.step'?"),
        ({"mesh": {"hub_radius": 1.0}}, "mesh.hub_radius", "did you mean 'blade.hub_radius'?"),
        ({"general": {"gravity": 1.0}}, "general.gravity", "did you mean 'loads.gravity'?"),
        ({"xyz": {"uvw": 1.0}}, "xyz.uvw", "there is no table 'xyz'"),
    ],
)
def test_unknown_key_comes_with_the_nearest_valid_one(data, key, hint):
    sentences = [s for s in mistakes(data) if s.startswith("unknown key")]
    assert len(sentences) == 1
    assert sentences[0].startswith(f"unknown key {key!r}; ")
    assert hint in sentences[0]


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (
            {"tower": {"flexible": True, "wall": "2 m"}},
            "tower.wall = 2: leaves no hollow, expected less than 2 m, half of the smaller "
            "diameter",
        ),
        (
            {"tower": {"flexible": True, "elements": [2, 1, 8]}},
            "tower.elements = [2, 1, 8]: expected 3 or more around the tower",
        ),
        (
            {"tower": {"flexible": True, "elements": [50000, 100, 100]}},
            "tower.elements = [50000, 100, 100]: gives some 1.2e+10 displacements, expected fewer "
            "than 2.1e+09",
        ),
        (
            {"pitch": {"bearings": True, "drive": "spring"}},
            'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0',
        ),
        (
            {"turbine": {"model": "rigid"}, "pitch": {"drive": "spring"}},
            'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0',
        ),
    ],
)
def test_contradictions_of_tower_and_pitch_are_refused(data, sentence):
    assert mistakes(data) == [sentence]


def test_tower_and_pitch_that_are_not_there_may_contradict_themselves():
    Case.parse({"tower": {"wall": 5.0, "elements": [1, 1, 1]}, "pitch": {"drive": "spring"}})


def test_every_mistake_has_its_own_sentence():
    sentences = mistakes(
        {"time": {"step": 0}, "material": {"density": -1}, "mesh": {"degre": 2}, "colour": "red"}
    )
    assert len(sentences) == 4
    for key in ("time.step", "material.density", "'mesh.degre'", "'colour'"):
        assert sum(key in s for s in sentences) == 1


def test_mistakes_within_and_between_keys_come_together():
    sentences = mistakes(
        {
            "time": {"step": "3 kg", "end": -1},
            "blade": {"chord": [1, 2], "thickness": ["1 s", 2, 3], "hub_radius": 0},
            "material": {
                "poisson": [0.9, 0.9, 0.9],
                "density": True,
                "law": "transversely_isotropic",
            },
            "loads": {"step": 1, "gravity": [1]},
            "solver": 3,
            "mesh": {"elements": [2, 2]},
        }
    )
    keys = ["time.step", "time.end", "blade.chord", "blade.thickness.0", "blade.hub_radius"]
    keys += ["material is not", "material.density", "unknown key 'loads.step'", "loads.gravity"]
    keys += ["solver", "mesh.elements"]
    assert sorted(s for s in sentences if not s.startswith(tuple(keys))) == []
    for key in keys:
        assert sum(s.startswith(key) for s in sentences) == 1, key


def test_nothing_is_said_about_keys_that_depend_on_wrong_ones():
    # three widths fit the default stations, but nobody knows what the stations were meant to be
    (sentence,) = mistakes({"blade": {"stations": "many", "chord": [1, 2], "thickness": [1, 2]}})
    assert sentence.startswith("blade.stations")


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        ({"turbine": {"model": "rigid"}, "material": {}, "mesh": {}}, ["material", "mesh"]),
        ({"turbine": {"blade_arm": 29, "blade": {}}}, ["turbine.blade", "turbine.blade_arm"]),
        ({"material": {"law": "neo_hooke", "young": [1, 1, 1]}}, ["material.young"]),
        ({"material": {"first_lame": 1}}, ["material.first_lame"]),
        ({"mesh": {"file": "a.msh", "elements": [1, 1, 1], "degree": 2}}, ["mesh.elements"]),
        ({"mesh": {"size": 1, "elements": [1, 1, 1]}}, ["mesh.elements"]),
        ({"loads": {"duration": 3}}, ["loads.duration"]),
        ({"loads": {"duration": 3, "yaw_torque": 1}}, []),
        ({"mesh": {"size": 1, "degree": 2}, "blade": {"chord": [1, 1, 1]}}, []),
        ({"tower": {"height": 1, "degree": 1}}, ["tower.degree", "tower.height"]),
        ({"tower": {"flexible": True, "height": 90, "degree": 1}}, []),
        ({"tower": {"flexible": False}}, []),
        ({"pitch": {"drive": "prescribed", "angle": 1}}, ["pitch.angle", "pitch.drive"]),
        ({"pitch": {"bearings": True, "ring_mass": 1, "drive": "free"}}, []),
        (
            {"pitch": {"bearings": True, "drive": "prescribed", "angle": 1, "stiffness": 1}},
            ["pitch.stiffness"],
        ),
        (
            {"pitch": {"bearings": True, "drive": "prescribed", "angle": 0, "start": 1}},
            ["pitch.start"],
        ),
        (
            {"pitch": {"bearings": True, "stiffness": 1, "angle": 1, "start": 1}},
            ["pitch.stiffness", "pitch.angle", "pitch.start"],
        ),
        (
            {"pitch": {"bearings": True, "drive": "spring", "damping": 1, "angle": 1}},
            ["pitch.angle"],
        ),
        ({"turbine": {"model": "rigid"}, "pitch": {"bearings": False}}, ["pitch.bearings"]),
        ({"turbine": {"model": "rigid"}, "pitch": {"drive": "prescribed", "angle": 1}}, []),
        ({"turbine": {"model": "rigid"}, "loads": {"pitch_torque": 1, "duration": 1}}, []),
        ({"loads": {"pitch_torque": 1}}, ["loads.pitch_torque"]),
        (
            {"loads": {"pitch_torque": 1}, "pitch": {"bearings": True, "drive": "prescribed"}},
            ["loads.pitch_torque"],
        ),
    ],
)  # fmt: skip
def test_keys_without_effect_are_named(data, keys):
    found = [sentence.split(" has no effect ")[0] for sentence in Case.parse(data).warnings]
    assert found == keys


def test_demos_have_no_keys_without_effect():
    paths = [path for folder in ("paper", "turbine") for path in (DEMOS.parent / folder).glob("*")]
    cases = [Case.load(path) for path in paths if path.suffix == ".toml"]
    assert len(cases) == 5
    assert [case.warnings for case in cases] == [[]] * 5


def test_defaults_have_neither_pitch_bearings_nor_a_flexible_tower():
    case = Case.parse({})
    assert not case.pitch.bearings and not case.tower.flexible
    assert (case.pitch.drive, case.loads.pitch_torque) == ("free", 0.0)
    assert case.tower.degree == 2


def test_material_of_a_rigid_turbine_may_be_anything():
    Case.parse({"turbine": {"model": "rigid"}, "material": {"poisson": [0.9, 0.9, 0.9]}})


def test_roots_that_overlap_are_refused():
    (sentence,) = mistakes({"blade": {"hub_radius": 0.5}})
    assert sentence.startswith("blade.hub_radius = 0.5: ")
    assert "at least 0.5196 m" in sentence  # 0.9 m / tan 60
    Case.parse({"blade": {"hub_radius": 0.52}})


def test_loading_a_case_does_not_need_a_library_of_units():
    # it would take longer than all the rest
    code = "import sys; from turbine_fenicsx.turbine.case.case import Case; Case.load(sys.argv[1]);"
    code += "assert not {'pint', 'ufl', 'dolfinx'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code, DEMOS / "rigid.toml"], check=True)


@pytest.fixture
def case_file(tmp_path):
    """Writes a case file and returns its path."""

    def write(text, name="case.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("override", "section", "name", "value"),
    [
        ("time.end=1.0", "time", "end", 1.0),
        ("time.end = 1", "time", "end", 1.0),
        ('time.step="10 ms"', "time", "step", 0.01),
        ("time.step=10 ms", "time", "step", 0.01),  # a string may go without quotes
        ("mesh.cell=tetrahedron", "mesh", "cell", "tetrahedron"),
        ("mesh.elements=[1, 1, 4]", "mesh", "elements", (1, 1, 4)),
        ("turbine.blade_arm=29.25", "turbine", "blade_arm", 29.25),
        ("loads.rotor_torque=-3.6e7", "loads", "rotor_torque", -3.6e7),
        ("output.fields_every=0", "output", "fields_every", 0.0),  # section not in the file
    ],
)
def test_override_replaces_a_key(case_file, override, section, name, value):
    path = case_file("[time]\nstep = 0.02\nend = 12.0\n[mesh]\ndegree = 2\n")
    case = Case.load(path, [override])
    assert getattr(getattr(case, section), name) == value
    assert case.mesh.degree == 2  # the rest stays


def test_last_override_wins(case_file):
    assert Case.load(case_file(""), ["time.end=1", "time.end=2"]).time.end == 2.0


@pytest.mark.parametrize("override", ["time.end", "=3", "time.=3", ".end=3", "", "time..end=1"])
def test_override_without_key_or_value_is_one_sentence(case_file, override):
    with pytest.raises(InputError) as error:
        Case.load(case_file(""), [override])
    assert str(error.value) == f"cannot read {override!r}: write --set section.key=value"


def test_override_of_what_is_no_table_is_one_sentence(case_file):
    with pytest.raises(InputError, match=r"cannot set 'time\.step\.x': 'step' is not a table"):
        Case.load(case_file("[time]\nstep = 0.02\n"), ["time.step.x=1"])


def test_unknown_key_in_an_override_gets_the_same_hint(case_file):
    with pytest.raises(InputError, match=r"unknown key 'time\.ende'; did you mean 'time\.end'\?"):
        Case.load(case_file(""), ["time.ende=1"])


def test_missing_file_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the case file .*No such file or directory"):
        Case.load(tmp_path / "none.toml")


def test_folder_is_no_case_file(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the case file .*Is a directory"):
        Case.load(tmp_path)


def test_what_would_never_end_is_no_case_file(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path / "fifo", "/dev/zero"):
        with pytest.raises(InputError, match=r"cannot read the case file .*not a regular file"):
            Case.load(path)
    with (tmp_path / "huge.toml").open("wb") as file:
        file.truncate(10**12)  # a hole, no bytes on the disk
    with pytest.raises(InputError, match=r"has 1000000000000 bytes, expected at most 10000000"):
        Case.load(tmp_path / "huge.toml")


def test_file_that_is_no_toml_is_one_sentence_with_the_line(case_file):
    with pytest.raises(InputError, match=r"is not valid TOML: .*line 2") as error:
        Case.load(case_file("[time]\nstep = 0.02 s\n"))
    assert "\n" not in str(error.value)


def test_file_in_another_encoding_is_one_sentence(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes('title = "Flügel"\n'.encode("latin-1"))
    with pytest.raises(InputError, match="it is not UTF-8 text"):
        Case.load(path)


def test_byte_order_mark_of_an_editor_is_no_mistake(tmp_path):
    (tmp_path / "bom.toml").write_bytes(b"\xef\xbb\xbf[time]\nend = 1.0\n")
    assert Case.load(tmp_path / "bom.toml").time.end == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = " + "[" * 100000, "nested too deeply"),
        (".".join(["time"] * 5000) + " = 1", "nested too deeply"),
        (f"[time]\nstep = {'9' * 5000}", "too many digits"),
        (f"[time]\nstep = 0x{'f' * 5000}", "time.step = a int too large to show"),
    ],
)
def test_what_python_itself_refuses_is_one_sentence(case_file, text, words):
    with pytest.raises(InputError, match=words) as error:
        Case.load(case_file(text))
    assert "\n" not in str(error.value)


def test_all_malformed_overrides_are_named(case_file):
    with pytest.raises(InputError) as error:
        Case.load(case_file("title = 'x'"), ["time.end", "=3", "title.x=3", "time.step=0"])
    assert len(str(error.value).splitlines()) == 4


def test_mesh_file_that_is_none_is_told_with_the_other_mistakes(case_file):
    path = case_file('[mesh]\nfile = "own.msh"\ndegree = 3\n')
    with pytest.raises(InputError, match=r"mesh.degree(.|\n)*cannot read .*own.msh'"):
        Case.load(path)
    path.with_name("own.msh").write_text("solid")
    with pytest.raises(InputError, match=r"mesh.file: .*own.msh' is not a mesh"):
        Case.load(path, ["mesh.degree=2"])
    assert Case.load(path, ["mesh.degree=2", "turbine.model=rigid"]).warnings


def test_mesh_file_is_relative_to_the_case_file(case_file, tmp_path):
    path = case_file('[mesh]\nfile = "meshes/own.msh"\n')
    other = tmp_path / "x.msh"
    (tmp_path / "meshes").mkdir()
    for file in (tmp_path / "meshes" / "own.msh", other):
        file.write_text("$MeshFormat\n")
    assert Case.load(path).mesh.file == str(tmp_path / "meshes" / "own.msh")
    assert Case.load(path, [f'mesh.file="{other}"']).mesh.file == str(other)


def test_case_cannot_be_changed_later():
    case = Case.parse({})
    with pytest.raises(ValueError, match="frozen"):
        case.time.step = 1.0
    with pytest.raises(ValueError, match="frozen"):
        case.time = case.time
