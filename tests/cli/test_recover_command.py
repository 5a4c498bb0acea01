"""The command that recovers the failure of plies from a run with reduced blades."""

import json
import shutil

import numpy as np
import pytest
from histories import read_columns
from reduced_turbines import COMM, run, write_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.parallel import on_rank0


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The folder of a run."""
    folder = on_rank0(COMM, lambda: tmp_path_factory.mktemp("recorded"))
    return run(write_case(folder), "run", "tower.flexible=false")


@pytest.fixture
def out(recorded, tmp_path):
    """A copy of the folder."""
    return shutil.copytree(recorded, tmp_path / "run")


def is_refused(command, capfd, *words):
    """Exit code 2 and one sentence with some words."""
    capfd.readouterr()
    assert main(command) == 2
    (sentence,) = capfd.readouterr().err.splitlines()
    for word in ("error: ", *words):
        assert word in sentence, sentence


def test_the_command_writes_and_prints_both(out, capfd):
    assert main(["recover", str(out)]) == 0
    first, *_, paths = capfd.readouterr().out.splitlines()
    assert first.startswith("nearest to failure: tsai_wu ")
    assert paths == f"{out}/plies.csv, {out}/worst.json"
    columns, worst = read_columns(out, "plies.csv"), json.loads((out / "worst.json").read_text())
    assert worst["index"] == np.max(columns[f"{worst['panel']}_tsai_wu_[-]"])
    before = (out / "plies.csv").read_bytes()
    is_refused(["recover", str(out), "--plies"], capfd, "plies.csv' is there already: --overwrite")
    assert main(["recover", str(out), "--plies", "--overwrite", "--quiet"]) == 0
    assert capfd.readouterr().out == ""
    assert (out / "plies.csv").read_bytes() == before


def test_a_cut_motion_is_recovered_up_to_its_last_whole_row(out, capfd):
    motion = (out / "motion.bin").read_bytes()
    (out / "motion.bin").write_bytes(motion[:-100])
    with pytest.warns(UserWarning, match="is whole up to row 5"):
        assert main(["recover", str(out), "--plies", "--quiet"]) == 0
    assert len(read_columns(out, "plies.csv")["time_[s]"]) == 5


def test_a_motion_without_a_whole_row_is_refused(out, capfd):
    (out / "motion.bin").write_bytes(b"")
    is_refused(["recover", str(out)], capfd, "motion.bin' holds no whole row")


def test_a_motion_without_its_basis_is_refused(out, capfd):
    (out / "basis_blades.npz").unlink()
    is_refused(["recover", str(out)], capfd, "basis_blades.npz' is missing, which motion.bin")


def test_a_motion_of_another_basis_is_refused(out, capfd):
    head = json.loads((out / "motion.json").read_text())
    head["bodies"][0]["meaning"] = "0123456789abcdef"
    (out / "motion.json").write_text(json.dumps(head))
    is_refused(["recover", str(out)], capfd, "motion.bin' does not belong to", "basis_blades.npz")


def test_a_run_without_reduced_blades_is_told_where_its_fields_are(out, capfd):
    case = json.loads((out / "case.json").read_text())
    case["blade"]["model"] = "full"
    (out / "case.json").write_text(json.dumps(case))
    is_refused(["recover", str(out)], capfd, "are not reduced", "fields.xdmf")


@pytest.mark.parametrize("name", ["motion.bin", "motion.json"])
def test_a_missing_motion_is_named(out, capfd, name):
    (out / name).unlink()
    is_refused(["recover", str(out)], capfd, f"{name}': No such file or directory")


def test_a_folder_without_a_run_is_refused(tmp_path, capfd):
    is_refused(["recover", str(tmp_path)], capfd, "there is no run in")
    is_refused(["recover", str(tmp_path / "none")], capfd, "there is no output folder")
