"""What `check` says where a windIO file contradicts itself or its case, or has an odd unit."""

import pytest
from windio_files import IEA_15, IEA_22, find_turbine, load_yaml, small_turbine, write_turbine

from turbine_fenicsx.turbine.case.case import Case

MATRICES = "components.blade.structure.elastic_properties"
NACELLE = "components.drivetrain"
CONTRADICTIONS = {
    IEA_15: [],
    IEA_22: ["generator.mass is 508 t, but that of generator.elastic_properties is 1269 t"],
}
SPEEDS = {"rated_rotor_speed": 30.0, "rated_power": 2e5, "max_gen_torque": 1.5e3}


def replace(tables, place, change):
    """Change a value of nested tables, or put one there."""
    *above, key = place.split(".")
    for name in above:
        tables = tables.setdefault(name, {})
    tables[key] = change(tables.get(key)) if callable(change) else change


def list_warnings(tables, folder, **case):
    write_turbine(tables, folder, "mine.yaml")
    turbine = {"file": "mine.yaml"} | case.pop("turbine", {})
    data = {"turbine": turbine, "time": {"start": "equilibrium"}, **case}
    return [x for x in Case.parse(data, folder).warnings if "has no effect" not in x]


@pytest.mark.parametrize("name", [IEA_15, IEA_22])
def test_reference_turbines_agree_with_themselves(name, tmp_path):
    odd = [x for x in list_warnings(load_yaml(find_turbine(name)), tmp_path) if "width" not in x]
    assert [x.partition(": ")[2] for x in odd] == CONTRADICTIONS[name]


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("assembly.rotor_diameter", 38.0, "rotor_diameter is 38 m, but 2 (hub radius"),
        ("assembly.hub_height", 45.0, "assembly.hub_height is 45 m, but the rotor centre"),
        ("control", SPEEDS | {"rated_power": 3e5}, "control.rated_power is 0.3 MW, but assembly"),
        ("control", SPEEDS | {"max_gen_torque": 1e3}, "0.1571 MW, but at least assembly.rated"),
        ("assembly.drivetrain", "direct_drive", "gearbox.gear_ratio is 50, but that of a direct"),
        (f"{MATRICES}.inertia_matrix.mass", [1e3, 5e2], "is 15.01 t, but the mass of its layup"),
        (
            "components.tower.structure.elastic_properties.inertia_matrix",
            {"grid": [0.0, 1.0], "mass": [1e2, 1e2]},
            "tower.structure.elastic_properties is 3.85 t, but the mass of its walls is 49.45 t",
        ),
        (f"{NACELLE}.generator.mass", 3e3, "generator.mass is 3 t, but that of generator.elastic"),
        (
            f"{NACELLE}.generator.elastic_properties.mass",
            2e4,
            "drivetrain.elastic_properties.mass is 10 t, but at least that of its generator is 20",
        ),
        (
            "components.monopile.reference_axis.z",
            {"grid": [0.0, 1.0], "values": [-20.0, 5.0]},
            "the base of the tower is 0 m, but the top of the monopile is 5 m",
        ),
        (
            "components.blade.reference_axis.x.values",
            [0.0, 0.1, 0.5],
            "reference_axis.x ends with 0.5 m, a prebend towards the tower",
        ),
        ("components.hub.cone_angle", 0.0524, "hub.cone_angle is 0.0524 deg, 0.3 to 20 deg are"),
        (f"{NACELLE}.outer_shape.uptilt", 0.0873, "is it in radians?"),
        (
            "components.blade.outer_shape.twist.values",
            [0.17, -0.02],
            "outer_shape.twist is 0.17 deg, 1 to 50 deg are usual; the format counts in deg; is",
        ),
        ("control", SPEEDS | {"optimal_tsr": 80.0}, "control.optimal_tsr is 80, 2 to 20 are"),
        (
            f"{MATRICES}.stiffness_matrix",
            lambda old: old | {"K33": [3e16, 3e15]},
            "the speed of sound along the blade, sqrt(K33 / mass)",
        ),
        ("assembly.rated_power", 2e6, "the rated power per area of the rotor is 1444 W/m^2"),
    ],
)
def test_a_contradiction_or_an_odd_number_is_one_sentence(place, value, words, tmp_path):
    tables = small_turbine()
    replace(tables, place, value)
    (sentence,) = list_warnings(tables, tmp_path)
    assert sentence.startswith("mine.yaml: ")
    assert words in sentence


@pytest.mark.parametrize(
    ("keys", "factor", "words"),
    [
        (("E", "G"), 1e-9, "materials['gelcoat'].E, with 4 more, is 3.44 Pa, 1e+05 to 2e+12 Pa"),
        (("rho",), 1e-3, "materials['gelcoat'].rho, with 4 more, is 1.235 kg/m^3, 20 to"),
    ],
)
def test_materials_in_other_units_are_one_sentence_for_all(keys, factor, words, tmp_path):
    tables = small_turbine()
    for material in tables["materials"]:
        for key in keys & material.keys():
            value = material[key]
            many = [factor * x for x in value] if isinstance(value, list) else factor * value
            material[key] = many
    assert any(words in sentence for sentence in list_warnings(tables, tmp_path))


@pytest.mark.parametrize(
    ("case", "words"),
    [
        ({"blade": {"hub_radius": 1.2}}, ["rotor_diameter is 42 m", "blade.hub_radius is 1.2 m"]),
        ({"turbine": {"hub_rise": 4.0}}, ["assembly.hub_height is 40 m, but the rotor centre"]),
    ],
)
def test_a_case_that_contradicts_its_file(case, words, tmp_path):
    tables = small_turbine()
    tables["assembly"]["rotor_diameter"] = 42.0
    sentences = list_warnings(tables, tmp_path, **case)
    assert len(sentences) == len(words)
    for part, sentence in zip(words, sentences, strict=True):
        assert part in sentence


@pytest.mark.parametrize("diameter", [42.0, 42.0 * 0.99863])  # the cone of 3 degrees or not
def test_a_diameter_counts_with_and_without_the_cone(diameter, tmp_path):
    tables = small_turbine()
    tables["assembly"]["rotor_diameter"] = diameter
    assert list_warnings(tables, tmp_path) == []


def test_what_is_only_compared_is_never_refused(tmp_path):
    tables = small_turbine()
    tables["components"]["monopile"] = {"reference_axis": "none"}
    replace(tables, f"{NACELLE}.generator.mass", "heavy")
    replace(tables, "components.tower.structure.elastic_properties", {"inertia_matrix": []})
    assert list_warnings(tables, tmp_path) == []


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"tower": {"flexible": True, "young": 210.0}}, "tower.young is 210 Pa, 1e+09 to 5e+11"),
        ({"tower": {"flexible": True, "density": "7.85 kg/m^3"}}, "tower.density is 7.85 kg/m^3"),
        ({"turbine": {"tilt": "-0.1 deg"}}, "turbine.tilt is -0.1 deg, 0.3 to 20 deg are usual; a"),
        (
            {"pitch": {"bearings": True, "drive": "prescribed", "angle": 5}},
            "pitch.angle is 286.5 deg, 0 to 110 deg are usual; a bare number counts in rad",
        ),
        ({"material": {"young": [45.0, 15.0, 15.0], "shear": [5.4e9] * 3}}, "young is 45 Pa"),
        ({"wind": {"speed": 5, "density": 1225}, "aero": {}}, "wind.density is 1225 kg/m^3"),
        ({"blade": {"twist": ["0.2 deg", 0, 0]}}, "blade.twist is 0.2 deg, 1 to 50 deg"),
        ({"event": {"stop": {"kind": "shut_down", "rate": 8}}}, "event.stop.rate is 458.4 deg/s"),
    ],
)
def test_unusual_keys_of_a_case_are_one_sentence(data, words):
    case = Case.model_validate(data)
    assert [x for x in case.warnings if words in x] != []


STORM = {"speed": "50 m/s", "direction": "20 deg"}
FEATHERED = {"bearings": True, "drive": "prescribed", "initial": "90 deg"}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"wind": STORM}, "a wind of 50 m/s from 20 deg is in deep stall"),
        ({"wind": {"speed": 50.0}}, "with blades not feathered is in deep stall"),
        ({"wind": {"speed": 50.0}, "pitch": FEATHERED}, ""),
        ({"wind": STORM | {"direction": "5 deg"}, "pitch": FEATHERED}, ""),
        ({"wind": STORM, "pitch": FEATHERED}, "a wind of 50 m/s from 20 deg is in deep stall"),
        ({"wind": STORM, "aero": {"dynamic_stall": "oeye"}}, ""),
        ({"wind": STORM, "turbine": {"model": "rigid"}}, ""),
        ({"wind": STORM | {"speed": 12.0}}, ""),
        ({"wind": STORM, "turbine": {"rotor_speed": "12 rpm"}}, ""),
    ],
)
def test_blades_that_stand_in_a_storm_need_dynamic_stall(data, words):
    found = [x for x in Case.model_validate(data).warnings if "deep stall" in x]
    assert len(found) == bool(words)
    assert all(words in sentence for sentence in found)


def test_unusual_keys_that_do_not_count_are_not_judged():
    warnings = Case.parse({"tower": {"flexible": False, "young": 210.0}}).warnings
    assert all("has no effect" in sentence for sentence in warnings)
