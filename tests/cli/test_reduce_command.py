"""``reduce`` makes, judges and draws the basis of reduced blades; ``check`` tells of it."""

import shutil

import numpy as np
import pytest
from reduced_turbines import write_case

from turbine_fenicsx.cli.main import main

SMALL = ("blade.reduction.modes=1", "blade.reduction.functions=6", "blade.reduction.strains=3")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The case beside its basis, and what was printed."""
    path = write_case(tmp_path_factory.mktemp("reduced"))
    assert main(["reduce", str(path), "--quiet", "--set", *SMALL]) == 0
    return path


@pytest.fixture
def path(made, tmp_path):
    """A copy of the case beside a copy of its basis."""
    shutil.copytree(made.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / made.name


def refused(capfd, *arguments):
    """The sentence that a command is refused with."""
    assert main(list(arguments)) == 2
    lines = [x for x in capfd.readouterr().err.splitlines() if not x.startswith("warning: ")]
    assert len(lines) == 1
    return lines[0].removeprefix("error: ")


def test_a_basis_is_kept_beside_the_case_with_its_verdict_and_picture(made):
    files = sorted((made.parent / "bases").iterdir())
    assert [file.suffix for file in files] == [".npz", ".png", ".txt"]
    assert {file.stem for file in files} == {files[0].stem}
    text = files[2].read_text()
    assert text.startswith("basis of 'blade': 6 functions, ")
    assert "wind of 8 m/s" in text
    assert files[1].stat().st_size > 10_000


def test_check_says_what_a_basis_costs_and_how_good_it_is(path, capfd):
    assert main(["check", str(path), "--set", *SMALL]) == 0
    out = capfd.readouterr().out
    assert "reduced blades: 6 functions and " in out
    assert "in place of 1935 displacements each, from " in out
    assert "the basis is judged: the body is too stiff by " in out
    for file in (path.parent / "bases").glob("*.txt"):
        file.unlink()
    assert main(["check", str(path), "--set", *SMALL]) == 0
    assert "the basis is not judged yet: the command reduce does that" in capfd.readouterr().out
    assert main(["check", str(path)]) == 0
    out = capfd.readouterr().out
    assert "reduced blades: 30 functions in place of 1935 displacements each; their basis is" in out
    assert "not made yet: a run makes it at the start" in out


def test_progress_and_verdict_are_printed_and_a_basis_that_is_there_is_taken(path, capfd):
    assert main(["reduce", str(path), "--set", *SMALL]) == 0
    printed = capfd.readouterr()
    assert "load path 5 of 5, 'wind of 13 m/s, 0.4 times its loads'" in printed.err
    assert "making the basis" not in printed.err
    assert printed.out.startswith("basis of 'blade': 6 functions, ")
    assert printed.out.splitlines()[-1].count("bases/blade-") == 2


def test_a_basis_goes_to_a_file_of_ones_own_and_runs_from_there(path, tmp_path, capfd):
    file = tmp_path / "mine.npz"
    (basis,) = (path.parent / "bases").glob("*.npz")
    shutil.copy(basis, file)
    assert "is there already: --overwrite replaces it" in refused(
        capfd, "reduce", str(path), "-o", str(file)
    )
    run = ["run", str(path), "-o", str(tmp_path / "out"), "--quiet", "--set"]
    changes = ["blade.reduction.file=mine.npz", "time.end=0.05", "output.gauges={}"]
    assert main([*run, *changes]) == 0
    kept = tmp_path / "out" / "basis_blades.npz"
    assert kept.read_bytes() == file.read_bytes()
    restart = ["restart", str(tmp_path / "out"), "--set"]
    kept.write_bytes(file.read_bytes()[:-100])  # damaged: that of the case is taken again
    assert main([*restart, "time.end=0.1"]) == 0
    assert kept.read_bytes() == file.read_bytes()
    with np.load(file) as arrays:
        changed = dict(arrays) | {"strain_factor": 1.02 * arrays["strain_factor"]}
    np.savez(kept, **changed)
    told = refused(capfd, *restart, "time.end=0.15")
    assert "the basis of 'blades' has changed, it was" in told


def test_names_that_are_wrong_are_refused(path, tmp_path, capfd):
    told = refused(capfd, "reduce", str(path), "-o", str(tmp_path / "basis"))
    assert told.endswith("expected a name that ends with .npz")
    told = refused(capfd, "reduce", str(path), "-o", str(tmp_path / "no" / "basis.npz"))
    assert told.endswith("is no folder that may be written")


def test_what_cannot_be_reduced_is_refused(path, capfd):
    rigid = ["--set", "turbine.model=rigid"]
    told = refused(capfd, "reduce", str(path), *rigid)
    assert told == 'turbine.model = "rigid": there are no flexible blades to reduce'
    (path.parent / "bases").rename(path.parent / "old")
    (path.parent / "bases").write_text("no folder")
    told = refused(capfd, "reduce", str(path))
    assert told == "there is no folder for the basis: name a file with -o"


@pytest.mark.parametrize("content", [b"", b"no basis", b"PK\x03\x04"])
def test_a_file_that_is_no_basis_is_refused_before_the_run(path, tmp_path, capfd, content):
    file = tmp_path / "wrong.npz"
    file.write_bytes(content)
    named = f"blade.reduction.file={file}"
    for command in (["check", str(path)], ["run", str(path), "-o", str(tmp_path / "out")]):
        told = refused(capfd, *command, "--set", named)
        assert "wrong.npz" in told
