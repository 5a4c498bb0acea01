"""Claims about likely slips in a case: each is one sentence, and the demos have none."""

from pathlib import Path

import pytest

from turbine_fenicsx.turbine.case.case import Case

ROOT = Path(__file__).parents[4] / "demos"
DEMOS = [p for folder in ("paper", "turbine") for p in sorted((ROOT / folder).glob("*.toml"))]
HOLLOW = {"blade": {"wall": ["30 mm", "20 mm", "5 mm"]}}
TOWER = {"flexible": True, "height": 80.0}


def find_doubts(case):
    """Warnings apart from those of keys without effect."""
    return [sentence for sentence in case.warnings if " has no effect " not in sentence]


@pytest.mark.parametrize("path", DEMOS, ids=lambda path: path.stem)
def test_demos_are_beyond_doubt(path):
    assert find_doubts(Case.load(path)) == []


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"tower": TOWER, "blade": {"length": 90.0}}, "reach 12.25 m into the ground"),
        (
            {"material": {"density": 2500.0}},
            "54 m has 235 t, built ones have about 13 t",
        ),
        (
            {"turbine": {"model": "rigid", "blade": {"mass": "0.1 t"}}},
            "a blade of 54 m has 0.1 t",
        ),
        (
            {"turbine": {"model": "rigid", "blade": {"mass": "1000 t"}}},
            "a blade of 54 m has 1e+03 t",
        ),
        (
            {"time": {"step": 2.0}, "loads": {"rotor_torque": 1.0}},
            "time.step = 2 s is too long to follow loads.duration = 3 s",
        ),
        (
            {
                "time": {"step": 2.0},
                "pitch": {"bearings": True, "drive": "prescribed", "angle": 1, "duration": 3.0},
            },
            "time.step = 2 s is too long to follow pitch.duration = 3 s",
        ),
        ({"time": {"start": "turning"}}, 'the same as "equilibrium" with turbine.rotor_speed = 0'),
        (
            {"turbine": {"rotor_speed": "12 rpm"}},
            "turbine.rotor_speed = 1.25664 rad/s: the blades are not yet stretched",
        ),
        (
            {"time": {"start": "equilibrium"}, "pitch": {"bearings": True}},
            "the pitch bearings are held while the start is found and let go then",
        ),
        (
            {"time": {"start": "turning", "step": 0.3}, "turbine": {"rotor_speed": "-12 rpm"}},
            "time.step = 0.3 s is long: the rotor turns by 21.6 degrees in a step",
        ),
        ({"solver": {"tolerance": 1e-3}}, "solver.tolerance = 0.001 is loose"),
        (HOLLOW, 'time.start = "undeformed": loads.gravity = 9.81 m/s^2 acts on thin walls'),
    ],
)
def test_slip_is_one_sentence(data, words):
    (sentence,) = find_doubts(Case.parse(data))
    assert words in sentence
    assert sentence in Case.parse(data).warnings


@pytest.mark.parametrize(
    "data",
    [
        {"blade": {"length": 90.0}},  # no tower
        {"tower": TOWER, "blade": {"length": 77.0}},
        {"time": {"step": 2.0}},  # no torque
        {"time": {"step": 1.5}, "loads": {"rotor_torque": 1.0}},
        {"mesh": {"file": "any.msh"}, "material": {"density": 25.0}},  # only the mesh knows
        {"time": {"start": "equilibrium"}},
        {"time": {"start": "turning"}, "turbine": {"rotor_speed": "12 rpm"}},
        {"turbine": {"rotor_speed": "12 rpm", "model": "rigid"}},  # nothing vibrates
        HOLLOW | {"time": {"start": "equilibrium"}},
        HOLLOW | {"loads": {"gravity": 0.0}},
    ],
)
def test_what_may_be_meant_is_not_doubted(data):
    assert find_doubts(Case.parse(data)) == []
