"""Nothing that took time to compute, and no file of the user's, is lost unasked."""

import json

import numpy as np
import pytest

from turbine_fenicsx import ReducedBasis, write_basis
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.reduction.basis_file import read_sizes
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import run_case

SHORT = ("--quiet", "--set", "time.end=0.06", "output.fields_every=0.02")
pytestmark = pytest.mark.usefixtures("no_pictures")


@pytest.fixture
def finished(demo, tmp_path, capfd):
    """A finished run, as a command that would do it again."""
    command = ["run", str(demo("rigid.toml")), "-o", str(tmp_path / "out"), *SHORT]
    assert main(command) == 0
    capfd.readouterr()
    return command


def content(folder):
    """All files of a folder, by name."""
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def is_refused(command, capfd, *words):
    """Exit code 2 and one sentence with some words."""
    assert main(command) == 2
    (sentence,) = capfd.readouterr().err.splitlines()
    assert sentence.startswith("error: ")
    for word in words:
        assert word in sentence


def test_a_second_run_is_refused_and_nothing_changes(
    finished, demo, tmp_path, comm, capfd, monkeypatch
):
    out = tmp_path / "out"
    before = content(out)

    def build(*_):
        raise AssertionError("heavy work before the refusal")

    monkeypatch.setattr("turbine_fenicsx.turbine.run.run.build_turbine", build)
    is_refused(finished, capfd, repr(str(out)), "--overwrite", "`turbine-fenicsx restart`")
    with pytest.raises(InputError, match="--overwrite"):
        run_case(Case.load(demo("rigid.toml")), out, comm, "none")
    assert content(out) == before


@pytest.mark.parametrize(
    "left", ["summary.json", "checkpoints", "history.csv", "one row", "no row", "case.json"]
)
def test_whatever_is_left_of_a_run_decides(finished, tmp_path, capfd, left):
    """A run that came no farther than its initial state is worth nothing."""
    out, data = tmp_path / "out", content(tmp_path / "out")
    for path in data:
        if left not in path.parts and not (left.endswith("row") and path.name == "history.csv"):
            (out / path).unlink()
    if left.endswith("row"):
        lines = data[next(p for p in data if p.name == "history.csv")].splitlines(keepends=True)
        (out / "history.csv").write_bytes(b"".join(lines[: 1 + (left == "one row")]))
    if left in ("summary.json", "checkpoints", "history.csv"):
        is_refused(finished, capfd, "--overwrite")
    else:
        assert main(finished) == 0


def test_overwriting_leaves_nothing_of_the_earlier_run(finished, demo, tmp_path):
    out = tmp_path / "out"
    (out / "notes.txt").write_text("mine")
    (out / "fields.old.bin").write_text("mine")
    assert main([*finished, "output.fields_every=0", "time.end=0.04", "--overwrite"]) == 0
    assert not (out / "fields.xdmf").exists() and not (out / "fields.bin").exists()
    assert len((out / "history.csv").read_text().splitlines()) == 4
    assert (out / "notes.txt").read_text() == (out / "fields.old.bin").read_text() == "mine"
    assert json.loads((out / "case.json").read_text())["time"]["end"] == 0.04


def test_a_case_that_cannot_be_built_overwrites_nothing(finished, tmp_path, capfd, monkeypatch):
    def build(*_):
        raise InputError("the mesh is inside out")

    before = content(tmp_path / "out")
    monkeypatch.setattr("turbine_fenicsx.turbine.run.run.build_turbine", build)
    is_refused([*finished, "--overwrite"], capfd, "inside out")
    after = content(tmp_path / "out")
    assert {p: d for p, d in after.items() if p.name != "run.log"} == {
        p: d for p, d in before.items() if p.name != "run.log"
    }


def test_a_mesh_file_is_not_replaced_unasked(demo, tmp_path, capfd, monkeypatch):
    path = tmp_path / "blade.msh"
    path.write_text("mine")
    command = ["mesh", str(demo("hybrid_stiff.toml")), "-o", str(path)]
    command += ["--set", "mesh.elements=[1,1,2]"]
    is_refused(command, capfd, repr(str(path)), "--overwrite")
    assert path.read_text() == "mine"
    assert main([*command, "--overwrite"]) == 0
    assert path.read_text().startswith("$MeshFormat")


def test_a_study_replaces_results_of_other_cases_only_if_asked(demo, tmp_path, capfd):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(
        f"case = '{demo('rigid.toml')}'\n[grid]\ntime.end = [0.02, 0.04]\n"
        "[set]\noutput.fields_every = 0\n"
    )
    command = ["study", str(study), "-o", str(out), "--quiet"]
    assert main(command) == 0
    capfd.readouterr()
    before = content(out)
    other = [*command, "--set", "time.step=0.01"]
    first = out / "time.end=0.02"
    is_refused(other, capfd, f"{str(first)!r} and 1 more", "--overwrite")
    assert content(out) == before
    assert main(command) == 0  # finished runs of the same case are read
    assert main([*other, "--overwrite"]) == 0
    assert len((first / "history.csv").read_text().splitlines()) == 4


PRECIOUS = b"years of work\n"


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (["mesh", "CASE", "-o"], "notes.msh"),
        (["mesh", "CASE", "-o"], "notes.txt"),
        (["demo", "rigid", "-o"], "notes.toml"),
        (["reduce", "CASE", "-o"], "notes.npz"),
        (["report", "OUT", "-o"], "notes.txt"),
        (["render", "OUT", "--movie"], "notes.txt"),
        (["run", "CASE", "-o"], "notes.txt"),
        (["modes", "CASE", "-o"], "notes.txt"),
        (["plot", "OUT", "-o"], "notes.txt"),
    ],
)
def test_no_command_replaces_a_file_of_another_kind(finished, demo, tmp_path, capfd, command, name):
    kept = tmp_path / name
    kept.write_bytes(PRECIOUS)
    places = {"CASE": str(demo("hybrid_stiff.toml")), "OUT": str(tmp_path / "out")}
    assert main([*(places.get(word, word) for word in command), str(kept)]) == 2
    assert capfd.readouterr().err.splitlines()[-1].startswith("error: ")
    assert kept.read_bytes() == PRECIOUS


@pytest.mark.parametrize("name", ["notes.txt", "arrays.npz"])
def test_a_basis_does_not_replace_a_file_of_another_kind(tmp_path, name):
    path, ones = tmp_path / name, np.ones(1)
    np.savez(tmp_path / "arrays.npz", measured=ones)
    (tmp_path / "notes.txt").write_bytes(PRECIOUS)
    before = path.read_bytes()
    point, vertical = np.zeros((1, 3)), np.zeros((6, 1))
    basis = ReducedBasis(
        points=point, functions=np.ones((1, 4)), masses=ones, origins=point,
        surface_of=np.zeros(1, dtype=int), mass=np.eye(4), strain_factor=vertical,
        viscosity=np.zeros(0), cells=np.zeros((1, 7)), singular_values=np.zeros(0),
    )  # fmt: skip
    with pytest.raises(InputError, match=rf"{name}.*: expected a name|{name}' holds other arrays"):
        write_basis(path, basis)
    assert path.read_bytes() == before
    for content in (b"", PRECIOUS):  # damaged
        (tmp_path / "basis.npz").write_bytes(content)
        write_basis(tmp_path / "basis.npz", basis)
        assert read_sizes(tmp_path / "basis.npz").nodes == 1
