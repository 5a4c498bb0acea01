"""Claims about turbulence boxes in a case: three files and the mean wind that carries them."""

import json
import tomllib

from mpi4py import MPI

import numpy as np
import pytest
from aero_files import write_aerodyn, write_box
from case_mistakes import mistakes

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.rotations import E1, E3
from turbine_fenicsx.study.plan import format_case
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import make_inflow
from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics
from turbine_fenicsx.turbine.run.resume import label_case, write_case

SIZE = {"points": [128, 17, 17], "spacing": ["5 m", "10 m", "10 m"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("box")


@pytest.fixture(scope="module")
def tables(folder):
    """A case in the wind of a box, as its file would have it."""
    return {
        "turbine": {"model": "rigid"},
        "aero": {"file": str(write_aerodyn(folder))},
        "wind": {
            "speed": 10.0,
            "shear": 0.0,
            "hub_height": "90 m",
            "box": {"files": write_box(folder), **SIZE},
        },
    }


def change(tables, **wind):
    box = {**tables["wind"]["box"], **wind.pop("box", {})}
    return {**tables, "wind": {**tables["wind"], **wind, "box": box}}


def test_a_box_is_carried_along_by_the_mean_wind(tables):
    given = Case.parse(change(tables, box={"scale": [2.0, 1.0, 1.0]}))
    assert given.warnings == []
    wind = make_inflow(given)
    # the box is 640 m long; after 16 s the top of its wave is at the hub
    assert wind.velocity(np.zeros(3), 16.0) == pytest.approx(14.0 * E3 + E1, abs=1e-6)
    assert wind.velocity(160.0 * E3, 32.0) == pytest.approx(14.0 * E3 + E1, abs=1e-6)
    assert wind.velocity(np.zeros(3), 80.0) == pytest.approx(14.0 * E3 + E1, abs=1e-6)
    first, _ = describe_aerodynamics(given)
    assert first == (
        "wind of 10 m/s at 90 m above ground, shear 0, with the turbulence of 'u.bin', 'v.bin', "
        "'w.bin', 128 x 17 x 17 points"
    )


def test_files_of_a_box_lie_beside_the_case(tables, folder):
    text = (folder / "case.toml").write_text(
        f"""
[turbine]
model = "rigid"
[aero]
file = "rotor.dat"
[wind]
speed = "10 m/s"
hub_height = "90 m"
[wind.box]
files = ["u.bin", "v.bin", "w.bin"]
points = {SIZE["points"]}
spacing = {SIZE["spacing"]}
"""
    )
    assert text and Case.load(folder / "case.toml").wind.box.files[2] == str(folder / "w.bin")


def test_a_box_without_files_changes_nothing(tables):
    box = {"points": [2, 2, 2], "spacing": [1, 1, 1]}
    given = Case.parse({**tables, "wind": {"speed": 10.0, "box": box}})
    assert set(given.warnings) == {
        f"wind.box.{key} has no effect without wind.box.files" for key in box
    }


@pytest.mark.parametrize(
    ("wind", "sentence"),
    [
        ({"speed": 0.0}, "wind.box.files: expected wind.speed greater than 0, the mean wind"),
        ({"gust": "EOG"}, 'wind.gust = "EOG": expected "none" beside wind.box'),
        ({"box": {"points": None}}, "wind.box.points: expected three numbers, along e3, e1 and"),
        ({"box": {"points": [128, 17, 1]}}, "wind.box.points.2 = 1: must be greater than or"),
        ({"box": {"spacing": ["5 m", 0, 1]}}, "wind.box.spacing.1 = 0: must be greater than 0"),
        ({"box": {"points": [64, 17, 17]}}, "wind.box.files: "),
        ({"box": {"files": ["u.bin", "v.bin"]}}, "wind.box.files"),
        ({"box": {"files": ["gone.bin", "b", "c"]}}, "wind.box.files: cannot read 'gone.bin'"),
        (
            {"box": {"spacing": [5, 5, 10]}},
            "wind.box.files: the wind field is 80 m wide, the rotor 112.5 m",
        ),
        ({"box": {"spacing": [0.05, 10, 10], "periodic": False}}, "wind.box.files: the wind field"),
    ],
)
def test_boxes_that_cannot_be_are_refused(tables, wind, sentence):
    found = mistakes(change(tables, **wind))
    assert any(line.startswith(sentence) for line in found), found


def test_a_box_that_has_changed_is_read_again_and_missing_ones_are_told(tables, folder):
    given = Case.parse(tables)
    before = make_inflow(given).velocity(np.zeros(3), 16.0)
    path = folder / "v.bin"
    (2.0 * np.fromfile(path, "<f4")).astype("<f4").tofile(path)
    after = make_inflow(given).velocity(np.zeros(3), 16.0)
    assert after - before == pytest.approx(E1, abs=1e-6)
    path.unlink()
    with pytest.raises(InputError, match=r"cannot read .*v\.bin"):
        make_inflow(given)


@pytest.fixture
def beside(tables, tmp_path, monkeypatch):
    """A case in a folder, with the files of its box by their names alone."""
    box = {**tables["wind"]["box"], "files": ["u.bin", "v.bin", "w.bin"]}
    write_box(tmp_path)
    monkeypatch.chdir(tmp_path)
    return Case.parse(change(tables, box=box))


def test_a_run_of_a_study_finds_its_box_from_another_folder(beside, tmp_path, monkeypatch):
    text = format_case(beside)
    monkeypatch.chdir("/")
    names = Case.parse(tomllib.loads(text)).wind.box.files
    assert names == tuple(str(tmp_path / f"{x}.bin") for x in "uvw")


def test_a_resumed_run_finds_its_box_from_another_folder(beside, tmp_path, monkeypatch):
    write_case(beside, tmp_path, MPI.COMM_SELF)
    monkeypatch.chdir("/")
    data = json.loads((tmp_path / "case.json").read_text())
    assert Case.parse(data).wind.box.files == tuple(str(tmp_path / f"{x}.bin") for x in "uvw")


def test_a_box_that_has_changed_is_noticed(beside, tmp_path):
    before, run = label_case(beside), format_case(beside)
    (np.fromfile(tmp_path / "w.bin", "<f4") + np.float32(1.0)).tofile(tmp_path / "w.bin")
    after = label_case(beside)
    assert {key for key in after if after[key] != before[key]} == {"turbulence box"}
    assert format_case(beside) != run


def test_a_file_that_changes_nothing_may_be_missing():
    case = Case.parse({"turbine": {"model": "rigid"}, "mesh": {"file": "gone.msh"}})
    assert label_case(case)["mesh"].startswith("missing (")
