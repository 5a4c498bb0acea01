"""Claims about keys of a case beside each other: contradictions, and keys without effect."""

import pytest
from case_mistakes import DEMOS, mistakes

from turbine_fenicsx.turbine.case.case import Case


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
            "tower.elements = [50000, 100, 100]: expected at most 1000000 elements, got 500000000",
        ),
        (
            {"mesh": {"elements": [100, 100, 101]}},
            "mesh.elements = [100, 100, 101]: expected at most 1000000 elements in each blade, got "
            "some 1.01e+06",
        ),
        (
            {"mesh": {"size": "1 cm", "cell": "tetrahedron"}},
            "mesh.size = 0.01: expected at most 1000000 elements in each blade, got some 1.2e+08",
        ),
        (
            {"pitch": {"bearings": True, "drive": "spring"}},
            'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0',
        ),
        (
            {"turbine": {"model": "rigid"}, "pitch": {"drive": "spring"}},
            'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0',
        ),
        (
            {"time": {"start": "equilibrium"}, "turbine": {"rotor_speed": "1 rad/s"}},
            'time.start = "equilibrium": expected turbine.rotor_speed = 0, got 1; "turning" is the '
            "equilibrium of a rotor that turns",
        ),
    ],
)
def test_contradictions_of_tower_and_pitch_are_refused(data, sentence):
    assert mistakes(data) == [sentence]


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (
            {"material": {"law": "neo_hooke"}},
            'blade.model = "reduced": expected a material.law that is quadratic in the strain, one '
            'of transversely_isotropic, st_venant_kirchhoff, windio, not "neo_hooke"',
        ),
        (
            {"time": {"scheme": "generalised_alpha"}},
            'blade.model = "reduced": expected time.scheme = "energy_momentum", not '
            '"generalised_alpha"',
        ),
        (
            {"blade": {"model": "reduced", "reduction": {"modes": 10, "functions": 29}}},
            "blade.reduction.functions = 29: expected at least 30, three for each of "
            "blade.reduction.modes = 10",
        ),
    ],
)
def test_contradictions_of_reduced_blades_are_refused(data, sentence):
    assert mistakes({"blade": {"model": "reduced"}} | data) == [sentence]


def test_rigid_blades_have_no_other_model_and_reduced_ones_no_fields():
    case = Case.parse({"turbine": {"model": "rigid"}, "blade": {"model": "reduced"}})
    assert not case.has_reduced_blades
    assert 'blade.model has no effect with turbine.model = "rigid"' in case.warnings
    tables = {"blade": {"model": "reduced"}, "output": {"fields_every": 0.2}}
    case = Case.parse(tables)
    assert case.fields_every == 0.0
    assert any(text.startswith("output.fields_every has no effect") for text in case.warnings)
    full = Case.parse(tables | {"blade": {"reduction": {"modes": 3}}})
    assert full.fields_every == 0.2
    assert 'blade.reduction has no effect with blade.model = "full"' in full.warnings


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
            {"time": {"ramp": "1 s"}},
            ["time.ramp"],
        ),
        ({"time": {"ramp": "1 s"}, "loads": {"yaw_torque": 1}}, []),
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
    assert sorted(found) == sorted(keys)


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
