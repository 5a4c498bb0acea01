"""Wall and twist of blades in a case: checks, keys without effect, and what is built of them."""

from math import pi

import numpy as np
import pytest
from case_mistakes import mistakes

from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case

HOLLOW = {"blade": {"wall": ["60 mm", "40 mm", "10 mm"]}, "mesh": {"span": 6, "around": 8}}


@pytest.mark.parametrize(
    ("blade", "sentence"),
    [
        (
            {"wall": [0.1, 0.1]},
            "blade.wall = (0.1, 0.1): expected one number for each of the 3 blade.stations, got 2",
        ),
        (
            {"wall": [0.1, 0.1, 0.1]},
            "blade.wall = 0.1 at station 1: leaves no hollow, expected less than 0.1 m, half of "
            "the section there",
        ),
        (
            {"twist": ["8 deg"]},
            f"blade.twist = ({8 * pi / 180},): expected one number for each of the 3 "
            "blade.stations, got 1",
        ),
    ],
)
def test_walls_and_twists_that_cannot_be_are_refused(blade, sentence):
    assert mistakes({"blade": blade}) == [sentence]


@pytest.mark.parametrize("key", ["wall", "twist"])
@pytest.mark.parametrize("value", [0.1, "thick", ["0.1 s", 0.1, 0.1], []])
def test_nonsense_is_refused_in_a_sentence_that_names_the_key(key, value):
    found = mistakes({"blade": {key: value}})
    assert len(found) == 1
    assert found[0].startswith(f"blade.{key}")


def test_twist_counts_in_degrees_if_it_says_so():
    case = Case.parse({"blade": {"twist": ["18 deg", "9 deg", 0]}})
    assert case.blade.twist == pytest.approx((pi / 10, pi / 20, 0.0))
    np.testing.assert_allclose(plan_rotor(case).blades.geometry.twist_at(0.2), pi / 20)


def test_keys_of_other_meshes_have_no_effect():
    rest = {"time": {"start": "equilibrium"}}
    assert Case.parse(HOLLOW | rest).warnings == []
    solid = Case.parse({"mesh": {"span": 6, "around": 8}}).warnings
    assert solid == [
        "mesh.span has no effect without blade.wall or turbine.file or blade.beam.file",
        "mesh.around has no effect without blade.wall or turbine.file or blade.beam.file",
    ]
    mesh = {"degree": 1, "size": 1.0, "elements": [2, 2, 4], "tip": "open"} | HOLLOW["mesh"]
    hollow = Case.parse({"blade": HOLLOW["blade"], "mesh": mesh} | rest).warnings
    assert [text.split(" has")[0] for text in hollow] == [
        "mesh.elements",
        "mesh.size",
        "mesh.degree",
        "mesh.tip",
    ]


def test_a_mesh_of_absurdly_many_elements_is_refused():
    mesh = {"span": 100_000, "around": 100_000}
    (sentence,) = mistakes({"blade": HOLLOW["blade"], "mesh": mesh})
    assert sentence.startswith(
        "mesh.span = 100000 and mesh.around = 100000: expected at most 1000000 "
    )


def test_a_wall_makes_hollow_blades():
    plan = plan_rotor(Case.parse(HOLLOW))
    _, make = plan.mesh_source()
    mesh = make()
    assert plan.list_mistakes(mesh) == ()
    assert plan.blades.degree == mesh.reference.degree == 2
    report = mesh.examine()
    assert sum(report.volumes.values()) == pytest.approx(3 * plan.blades.geometry.volume, rel=0.01)
    assert "of the ideal shape" in plan.blades.describe(report, mesh, plan.layout)[0]
