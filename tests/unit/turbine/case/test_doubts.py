"""Claims about likely slips in a case: each is one sentence, and the demos have none."""

from pathlib import Path

import pytest

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.doubts import doubts

ROOT = Path(__file__).parents[4] / "demos"
DEMOS = [p for folder in ("paper", "turbine") for p in sorted((ROOT / folder).glob("*.toml"))]
TOWER = {"flexible": True, "height": 80.0}


@pytest.mark.parametrize("path", DEMOS, ids=lambda path: path.stem)
def test_demos_are_beyond_doubt(path):
    assert doubts(Case.load(path)) == []


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"tower": TOWER, "blade": {"length": 90.0}}, "reach 12.25 m into the ground"),
        (
            {"material": {"density": 2500.0}},
            "54 m has 235 t, built ones have about 13 t",
        ),
        ({"material": {"density": 1.0}}, "a blade of 54 m has 0.0941 t"),
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
    ],
)
def test_slip_is_one_sentence(data, words):
    (sentence,) = doubts(Case.parse(data))
    assert words in sentence
    assert sentence in Case.parse(data).warnings


@pytest.mark.parametrize(
    "data",
    [
        {"blade": {"length": 90.0}},  # no tower
        {"tower": TOWER, "blade": {"length": 77.0}},
        {"time": {"step": 2.0}},  # no torque
        {"time": {"step": 1.5}, "loads": {"rotor_torque": 1.0}},
        {"mesh": {"file": "any.msh"}, "material": {"density": 1.0}},  # only the mesh knows
    ],
)
def test_what_may_be_meant_is_not_doubted(data):
    assert doubts(Case.parse(data)) == []
