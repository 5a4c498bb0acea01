"""``restart`` refuses what does not belong together, and finds a mesh from anywhere."""

import json
import os
import re
import shutil
import signal
from contextlib import contextmanager

import pytest
from histories import read_lines
from restarted_runs import content, restart, run

from turbine_fenicsx.cli.main import main

pytestmark = pytest.mark.usefixtures("no_pictures")


@contextmanager
def soon():
    """What takes more than a minute here waits for something that never comes."""

    def give_up(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(60)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def refused(tmp_path, capfd, *changes, words):
    """The restart is refused in one sentence, and no file has changed."""
    before = content(tmp_path)
    capfd.readouterr()
    restart(tmp_path, *changes, code=2)
    (sentence,) = capfd.readouterr().err.splitlines()
    assert sentence.startswith("error: ")
    assert re.search(words, sentence), sentence
    assert content(tmp_path) == before


def test_another_version_is_refused(demo, tmp_path, capfd, monkeypatch):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    monkeypatch.setattr("turbine_fenicsx.simulation.checkpoint.__version__", "9.9.9")
    refused(tmp_path, capfd, words=r"version of turbine_fenicsx has changed, it was .* is 9\.9\.9")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("loads.gravity=1.0", "loads.gravity cannot change"),
        ("turbine.rotor_speed=1", "turbine.rotor_speed cannot change"),
        ("turbine.azimuth=1", "turbine.azimuth cannot change"),
        ("time.start=turning", "time.start cannot change in a resumed run; it is how it began"),
        ("time.ramp=1", "time.ramp cannot change in a resumed run; it is how it began"),
        ("turbine.hub.mass=1e5", "turbine.hub cannot change"),
        ("mesh.elements=[1,1,2]", "mesh.elements cannot change"),
        ("time.stop=3", "time.stop"),
        ("output.channels=[]", r"output\.channels cannot change in a resumed run; history\.out"),
        ("output.format=vtkhdf", r"output\.format cannot change in a resumed run"),
        ("time.end=-1", "time.end"),
    ],
)
def test_what_may_not_change_is_refused(demo, tmp_path, capfd, change, words):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    refused(tmp_path, capfd, change, words=words)


def test_a_case_that_was_edited_is_refused(demo, tmp_path, capfd):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    path = tmp_path / "case.json"
    case = json.loads(path.read_text())
    case["loads"]["gravity"] = 1.0
    path.write_text(json.dumps(case))
    refused(tmp_path, capfd, words="the case has changed")


def test_a_mesh_file_that_has_changed_is_refused(demo, tmp_path, capfd):
    mesh, out = tmp_path / "blade.msh", tmp_path / "out"
    case = str(demo("hybrid_soft.toml"))

    def write_mesh(elements):
        command = ["mesh", case, "-o", str(mesh), "--overwrite"]
        assert main([*command, "--set", f"mesh.elements={elements}"]) == 0

    write_mesh([1, 1, 2])
    run(demo, "hybrid_soft", out, "time.end=0.04", f"mesh.file={mesh}")
    write_mesh([1, 1, 3])
    refused(out, capfd, words="the mesh has changed")
    mesh.unlink()
    refused(out, capfd, words="blade.msh")


def test_a_mesh_file_is_found_from_anywhere(demo, tmp_path, monkeypatch):
    """The case names it relative to itself, and is named relative to where one was."""
    (tmp_path / "cases").mkdir()
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    text = demo("hybrid_soft.toml").read_text().replace("[mesh]", '[mesh]\nfile = "blade.msh"')
    (tmp_path / "cases" / "case.toml").write_text(text)
    case = str(demo("hybrid_soft.toml"))
    assert main(["mesh", case, "-o", "cases/blade.msh", "--set", "mesh.elements=[1,1,2]"]) == 0
    assert main(["run", "cases/case.toml", "-o", "out", "--quiet", "--set", "time.end=0.04"]) == 0
    monkeypatch.chdir(tmp_path / "elsewhere")
    restart(tmp_path / "out", "time.end=0.06")
    assert len(read_lines(tmp_path / "out")) == 5


@pytest.mark.parametrize("what", ["nothing", "empty", "no checkpoint", "only broken ones"])
def test_a_folder_without_a_run_is_refused(demo, tmp_path, capfd, what):
    out = tmp_path / "out"
    if what == "empty":
        out.mkdir()
    if what in ("no checkpoint", "only broken ones"):
        run(demo, "rigid", out, "time.end=0.04")
        for path in (out / "checkpoints").iterdir():
            path.write_bytes(b"") if what == "only broken ones" else path.unlink()
    words = {
        "no checkpoint": "there is no checkpoint in",
        "only broken ones": "no checkpoint in .* can be used",
    }
    refused(out, capfd, words=words.get(what, "there is no run in '.*/out' to resume"))
    assert out.exists() == (what != "nothing")


@pytest.fixture(scope="module")
def short_run(demo, tmp_path_factory):
    """The folder of a short run with fields."""
    folder = tmp_path_factory.mktemp("run")
    changes = ("mesh.elements=[1,1,2]", "time.end=0.04", "output.fields_every=0.02")
    run(demo, "hybrid_soft", folder, *changes)
    return folder


@pytest.mark.parametrize(
    "name", ["history.csv", "history.out", "fields.xdmf", "case.json", "run.log"]
)
def test_a_pipe_in_place_of_a_file_is_refused(short_run, tmp_path, capfd, name):
    """Nobody writes into it, so that to open it would never end."""
    out = tmp_path / "out"
    shutil.copytree(short_run, out)
    (out / name).unlink()
    os.mkfifo(out / name)
    with soon():
        refused(out, capfd, "time.end=0.06", words=f"{re.escape(name)}'?: it is not a regular file")


def test_a_pipe_in_place_of_a_checkpoint_is_passed_over(short_run, tmp_path, capfd):
    out = tmp_path / "out"
    shutil.copytree(short_run, out)
    newest = max((out / "checkpoints").iterdir())
    newest.unlink()
    os.mkfifo(newest)
    with soon():
        restart(out, "time.end=0.06")
    assert "cannot be read: it is not a regular file" in capfd.readouterr().err
    assert len(read_lines(out)) == 5
