"""Claims about case files: units, defaults, overrides, and one sentence for every mistake."""

from pathlib import Path

import pytest

from turbine_fenicsx.errors import InputError
from turbine_fenicsx.turbine.case import Case
from turbine_fenicsx.turbine.quantities import to_si

DEMOS = Path(__file__).parents[2] / "demos" / "paper"


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
    assert sentence.startswith(f"time.step = {text!r}: give a number in s")


@pytest.mark.parametrize("text", ["1,5 s", "1.500,0 s", "s", "12 s ; 3", "2*3 s"])
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
        ("time.step", float("nan"), "must be"),
        ("time.step", "inf", "finite"),
        ("time.end", -1.0, "greater than or equal to 0"),
        ("time.end", float("inf"), "finite"),
        ("material.density", -1500.0, "greater than 0"),
        ("material.density", "-1500 kg/m^3", "greater than 0"),
        ("material.density", "1500 kg", "a number in kg/m^3"),
        ("material.first_lame", float("nan"), "finite"),
        ("material.law", "steel", "'transversely_isotropic', 'st_venant_kirchhoff' or 'neo_hooke'"),
        ("turbine.model", "flexible", "'rigid' or 'hybrid'"),
        ("turbine.angle_form", "other", "'regular' or 'paper'"),
        ("turbine.hub_distance", 0, "greater than 0"),
        ("mesh.cell", "wedge", "'hexahedron' or 'tetrahedron'"),
        ("mesh.degree", 3, "1 or 2"),
        ("mesh.size", "0 m", "greater than 0"),
        ("loads.rotor_torque", "3 kN", "a number in N m"),
        ("loads.duration", 0.0, "greater than 0"),
        ("loads.gravity", "-9.81 m/s^2", "greater than or equal to 0"),
        ("solver.preconditioner", "magic", "'lu' or 'monolithic'"),
        ("solver.tolerance", 0.0, "greater than 0"),
        ("solver.max_iterations", 0, "greater than or equal to 1"),
        ("output.fields_every", -0.1, "greater than or equal to 0"),
    ],
)
def test_value_out_of_range_is_one_sentence_with_key_value_and_range(key, value, text):
    section, name = key.split(".")
    (sentence,) = mistakes({section: {name: value}})
    assert sentence.startswith(f"{key} = {value!r}: ")
    assert text in sentence


@pytest.mark.parametrize(
    ("elements", "key"),
    [
        ([2, 2], "mesh.elements"),
        ([2, 2, 12, 1], "mesh.elements"),
        ([2, 2, 0], "mesh.elements.2"),
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
    assert "greater than 0" in sentence or "in m" in sentence


@pytest.mark.parametrize(
    ("data", "key", "hint"),
    [
        ({"materail": {}}, "materail", "did you mean 'material'?"),
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
    ],
)
def test_unknown_key_comes_with_the_nearest_valid_one(data, key, hint):
    sentences = [s for s in mistakes(data) if s.startswith("unknown key")]
    assert len(sentences) == 1
    assert sentences[0].startswith(f"unknown key {key!r}; ")
    assert hint in sentences[0]


def test_every_mistake_has_its_own_sentence():
    sentences = mistakes(
        {"time": {"step": 0}, "material": {"density": -1}, "mesh": {"degre": 2}, "colour": "red"}
    )
    assert len(sentences) == 4
    for key in ("time.step", "material.density", "'mesh.degre'", "'colour'"):
        assert sum(key in s for s in sentences) == 1


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


def test_file_that_is_no_toml_is_one_sentence_with_the_line(case_file):
    with pytest.raises(InputError, match=r"is not valid TOML: .*line 2") as error:
        Case.load(case_file("[time]\nstep = 0.02 s\n"))
    assert "\n" not in str(error.value)


def test_file_in_another_encoding_is_one_sentence(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes('title = "Flügel"\n'.encode("latin-1"))
    with pytest.raises(InputError, match="it is not UTF-8 text"):
        Case.load(path)


def test_mesh_file_is_relative_to_the_case_file(case_file, tmp_path):
    path = case_file('[mesh]\nfile = "meshes/own.msh"\n')
    assert Case.load(path).mesh.file == str(tmp_path / "meshes" / "own.msh")
    assert Case.load(path, ['mesh.file="/elsewhere/x.msh"']).mesh.file == "/elsewhere/x.msh"


def test_case_cannot_be_changed_later():
    case = Case.parse({})
    with pytest.raises(ValueError, match="frozen"):
        case.time.step = 1.0
    with pytest.raises(ValueError, match="frozen"):
        case.time = case.time
