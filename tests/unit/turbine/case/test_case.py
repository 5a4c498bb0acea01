"""Claims about cases: defaults, and one sentence for every wrong value."""

import subprocess
import sys

import pytest
from case_mistakes import DEMOS, mistakes

from turbine_fenicsx.turbine.case.case import Case


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
        ("material.law", "steel", "'neo_hooke' or 'windio'"),
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
        ("mesh.size", 1e-9, "elements in each blade"),
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
        ("pitch.drive", "motor", "'free', 'lock', 'spring', 'prescribed' or 'actuator'"),
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
        ({"mesh": {"wxyzwxyz": 1}}, "mesh.wxyzwxyz", "[mesh] takes around, cell, degree, elements"),
        ({"qqq": 1}, "qqq", "a case file takes aero, blade, control, drivetrain, event, generator"),
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


def test_loading_a_case_does_not_need_a_library_of_units():
    # it would take longer than all the rest
    code = "import sys; from turbine_fenicsx.turbine.case.case import Case; Case.load(sys.argv[1]);"
    code += "assert not {'pint', 'ufl', 'dolfinx'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code, DEMOS / "rigid.toml"], check=True)


def test_case_cannot_be_changed_later():
    case = Case.parse({})
    with pytest.raises(ValueError, match="frozen"):
        case.time.step = 1.0
    with pytest.raises(ValueError, match="frozen"):
        case.time = case.time
