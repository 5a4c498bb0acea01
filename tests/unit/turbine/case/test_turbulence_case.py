"""Claims about turbulence that a case asks for: how much, how large, how long, and kept where."""

import json
import logging

from mpi4py import MPI

import numpy as np
import pytest
from aero_files import write_aerodyn
from case_mistakes import mistakes

from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import plan
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import load_box, make_inflow
from turbine_fenicsx.turbine.case.turbulence import TurbulencePlan
from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics
from turbine_fenicsx.turbine.run.resume import fix_duration, label_case, read_case, write_case

MADE = {"model": "kaimal", "points": 5, "time_step": 1.0, "duration": 120.0}
CASE = """
[turbine]
model = "rigid"
[aero]
file = "rotor.dat"
[wind]
speed = "10 m/s"
shear = 0
hub_height = "90 m"
turbulence = {model = "kaimal", points = 5, time_step = "1 s", duration = "120 s"}
"""


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    return {
        "turbine": {"model": "rigid"},
        "aero": {"file": str(write_aerodyn(tmp_path_factory.mktemp("aero")))},
        "wind": {"speed": 10.0, "shear": 0.0, "hub_height": 90.0, "turbulence": MADE},
    }


@pytest.fixture
def beside(tmp_path):
    """A case file with its aerodynamics."""
    write_aerodyn(tmp_path)
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def change(tables, **wind):
    made = {**tables["wind"]["turbulence"], **wind.pop("turbulence", {})}
    return {**tables, "wind": {**tables["wind"], **wind, "turbulence": made}}


def plan_of(tables, **wind):
    return TurbulencePlan.of(Case.parse(change(tables, **wind)))


def test_its_deviation_is_that_of_the_class_of_a_level_or_as_given(tables):
    assert plan_of(tables).deviation == pytest.approx(0.14 * (0.75 * 10.0 + 5.6))
    assert plan_of(tables, turbine_class="IIIC").deviation == pytest.approx(0.12 * 13.1)
    extreme = 2.0 * 0.18 * (0.072 * (8.5 / 2.0 + 3.0) * (10.0 / 2.0 - 4.0) + 10.0)
    found = plan_of(tables, turbine_class="IIA+", turbulence={"level": "extreme"})
    assert found.deviation == pytest.approx(extreme)
    assert plan_of(tables, turbulence={"intensity": 0.1}).deviation == pytest.approx(1.0)
    assert plan_of(tables).length == 42.0
    assert plan_of(tables, hub_height=58.0).length == pytest.approx(0.7 * 58.0)


def test_its_grid_goes_around_the_rotor_and_lasts_for_the_run(tables):
    n_x, n_y, _ = plan_of(tables).grid.points
    assert (n_x, n_y) == (120, 5) and plan_of(tables).grid.spacing[0] == pytest.approx(10.0)
    y, z = plan_of(tables).grid.sides
    assert y[-1] == z[-1] == pytest.approx(1.15 * 56.25)
    _, z = plan_of(tables, hub_height=60.0).grid.sides  # not below the ground
    assert z[-1] == pytest.approx(60.0)
    free = {"duration": None}
    assert plan_of(tables, turbulence=free).grid.points[0] == 600
    long = {**change(tables, turbulence=free), "time": {"end": 700.0}}
    assert TurbulencePlan.of(Case.parse(long)).grid.points[0] == 700


def test_its_name_follows_from_all_that_it_depends_on(tables):
    name = plan_of(tables).name
    assert plan_of(tables, shear=0.3, direction=0.2).name == name  # the same box
    for wind in (
        {"speed": 11.0},
        {"turbine_class": "IA"},
        *({"turbulence": one} for one in ({"seed": 2}, {"model": "mann"}, {"width": 150.0})),
    ):
        assert plan_of(tables, **wind).name != name


def test_it_is_kept_beside_the_case_and_made_again_where_damaged(beside, caplog):
    caplog.set_level(logging.INFO)
    case = Case.load(beside)
    first = load_box(case).fluctuations.values
    (path,) = (beside.parent / "turbulence").iterdir()
    assert path.name == TurbulencePlan.of(case).name
    assert "the turbulence is kept in" in caplog.text

    def load_anew(**change):
        caplog.clear()
        # another folder is another file, which a process reads once
        other = beside.parent / f"other{len(list(beside.parent.iterdir()))}"
        other.mkdir()
        content = path.read_bytes()
        (other / path.name).write_bytes(change.get("content", content))
        turned = Case.load(beside, [f"wind.turbulence.folder={other}"])
        return load_box(turned).fluctuations.values

    assert np.array_equal(load_anew(), first) and caplog.text == ""
    for content in (b"", path.read_bytes()[:2000], path.read_bytes().replace(b"<f4", b"<f8")):
        assert np.array_equal(load_anew(content=content), first)
        assert "damaged; it is made again" in caplog.text


def test_a_folder_that_cannot_be_written_is_told_and_the_wind_blows_on(beside, caplog):
    case = Case.load(beside, ["wind.turbulence.folder=nowhere/box", "wind.turbulence.seed=7"])
    assert load_box(case).fluctuations.values.std() > 0.5
    assert "which is no folder for writing" in caplog.text


@pytest.mark.parallel
def test_all_ranks_have_the_wind_of_the_first(tables, comm):
    wind = make_inflow(Case.parse(change(tables)), comm)
    found = comm.allgather(wind.velocity(np.array([[3.0, 20.0, 5.0], [0.0, -40.0, 9.0]]), 2.5))
    assert all(np.array_equal(one, found[0]) for one in found) and np.ptp(found[0][:, 2]) > 0.0


def test_a_wind_can_be_turned_as_a_whole(tables):
    straight = make_inflow(Case.parse(change(tables)))
    turned = make_inflow(Case.parse(change(tables, direction=0.3, inclination=0.1)))
    along = np.cos(0.1) * (np.cos(0.3) * E3 + np.sin(0.3) * E1) + np.sin(0.1) * E2
    across = np.cos(0.3) * E1 - np.sin(0.3) * E3
    up = np.cross(along, across)
    for x, y, z in ((0.0, 0.0, 0.0), (5.0, 20.0, -30.0)):
        before = straight.velocity(x * E3 + y * E1 + z * E2, 3.7)
        after = turned.velocity(x * along + y * across + z * up, 3.7)
        assert after @ [along, across, up][0] == pytest.approx(before @ E3)
        assert after @ across == pytest.approx(before @ E1)
        assert after @ up == pytest.approx(before @ E2)


def test_it_is_described_and_one_that_begins_anew_is_doubted(tables):
    case = Case.parse({**change(tables), "time": {"end": 130.0}})
    assert case.warnings == [
        "wind.turbulence.duration = 120 s is less than time.end = 130 s: the wind restarts"
    ]
    first, _ = describe_aerodynamics(case)
    assert first.endswith(
        "with turbulence by Kaimal's model, intensity 18.3 %, seed 1: 120 x 5 x 5 points, 120 s, "
        "129.4 m wide"
    )


@pytest.mark.parametrize(
    ("wind", "sentence"),
    [
        ({"speed": 0.0}, "wind.turbulence.model: expected wind.speed greater than 0, the mean"),
        ({"gust": "EOG"}, 'wind.gust = "EOG": expected "none" beside wind.turbulence'),
        ({"turbine_class": "IVB"}, "wind.turbine_class = 'IVB': must be 'IA+', "),
        (
            {"turbulence": {"model": "karman"}},
            "wind.turbulence.model = 'karman': must be 'none', 'kaimal' or ",
        ),
        ({"turbulence": "B"}, "wind.turbulence = 'B': "),
        ({"turbulence": {"seed": -1}}, "wind.turbulence.seed = -1: "),
        ({"turbulence": {"points": 65}}, "wind.turbulence.points = 65: "),
        ({"turbulence": {"intensity": 14}}, "wind.turbulence.intensity = 14: "),
        ({"turbulence": {"duration": 3.0}}, "wind.turbulence.duration = 3: expected at least four"),
        ({"turbulence": {"width": 80.0}}, "wind.turbulence: the wind field is 80 m wide, the"),
        ({"turbulence": {"time_step": 1e-320}}, "wind.turbulence: a turbulence box of 559 GiB is"),
        ({"turbulence": {"time_step": 1e-6}}, "wind.turbulence: a turbulence box of 33.5 GiB is"),
        (
            {"box": {"files": ["u", "v", "w"], "points": [9, 9, 9], "spacing": [1, 1, 1]}},
            'wind.turbulence.model: expected "none" beside wind.box.files',
        ),
        ({"speed": None, "file": "a.bts"}, "wind.turbulence.model: expected none beside wind.file"),
    ],
)
def test_turbulence_that_cannot_be_is_refused(tables, wind, sentence):
    old = isinstance(wind.get("turbulence"), str)
    found = mistakes({**tables, "wind": {"speed": 10.0, **wind}} if old else change(tables, **wind))
    assert any(line.startswith(sentence) for line in found), found


def test_a_table_without_a_model_changes_nothing(tables):
    given = Case.parse({**tables, "wind": {"speed": 10.0, "turbulence": {"seed": 3}}})
    assert given.warnings == [
        'wind.turbulence.seed has no effect with wind.turbulence.model = "none"'
    ]


def test_a_resumed_run_that_ends_later_has_the_same_wind(tables, tmp_path):
    case = fix_duration(Case.parse(change(tables, turbulence={"duration": None})))
    write_case(case, tmp_path, MPI.COMM_SELF)
    assert json.loads((tmp_path / "case.json").read_text())["wind"]["turbulence"]["duration"] == 600
    later = read_case(tmp_path, ["time.end=900"])
    assert TurbulencePlan.of(later) == TurbulencePlan.of(case)
    assert label_case(later) == label_case(case)


def test_runs_of_a_study_share_their_wind(beside, tmp_path):
    study = Study.model_validate(
        {"case": str(beside), "grid": {"wind.shear": [0.1, 0.2], "wind.turbulence.seed": [1, 2]}}
    )
    runs = plan(study)
    assert {run.case.wind.turbulence.folder for run in runs} == {str(tmp_path / "turbulence")}
    assert len({TurbulencePlan.of(run.case).name for run in runs}) == 2
