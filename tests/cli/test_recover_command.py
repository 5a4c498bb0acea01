"""The command that recovers the failure of plies from a run with reduced blades."""

import json
import os
import shutil
import sys

import numpy as np
import pytest
from histories import read_columns
from reduced_turbines import COMM, run, write_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile
from turbine_fenicsx.simulation.observers.fields import Fields


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
    assert paths.startswith(f"{out}/plies.csv, {out}/worst.json")
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


FIELDS = ["--fields", "--times", "max(tsai_wu)"]


def test_fields_at_the_worst_moment_have_its_index_and_can_be_drawn(out, capfd):
    pytest.importorskip("h5py")
    assert main(["recover", str(out), "--worst", *FIELDS, "--quiet"]) == 0
    worst = json.loads((out / "worst.json").read_text())
    with VtkHdfFile(out / "fields.vtkhdf") as file:
        assert file.times.tolist() == [worst["time"]]
        step = file.read(0)
    names = {"tsai_wu", "von_mises_stress", "cauchy_stress_norm", "fibre", "part"}
    assert set(step.cell_data) == names
    assert set(step.point_data) == {"displacement", "velocity", "coupling"}
    assert step.cell_data["tsai_wu"].max() == pytest.approx(worst["index"], rel=1e-6)
    if main(["render", str(out), "--field", "tsai_wu", "--size", "160x120"]) != 0:
        pytest.skip(capfd.readouterr().err)
    assert (out / f"turbine_t{worst['time']:.6g}.png").exists()


def test_a_report_shows_the_worst_moment_and_keeps_it(out, capfd):
    is_refused(["report", str(out), "-o", "page.txt"], capfd, "--out page.txt: the name of a page")
    assert not (out / "worst.json").exists()  # it takes long
    assert main(["report", str(out), "--no-pictures"]) == 0
    page = (out / "report.html").read_text()
    worst = json.loads((out / "worst.json").read_text())
    assert f"s the index of tsai_wu is {worst['index']:.3g} in" in page
    assert "Failure index of the plies in all blades" in page
    assert not (out / "worst.png").exists()
    before = (out / "worst.json").stat().st_mtime_ns
    assert main(["report", str(out), "--no-pictures"]) == 0
    assert (out / "worst.json").stat().st_mtime_ns == before
    os.utime(out / "motion.bin")
    assert main(["report", str(out), "--no-pictures"]) == 0
    assert (out / "worst.json").stat().st_mtime_ns > before
    (out / "basis_blades.npz").unlink()
    os.utime(out / "motion.bin")
    assert main(["report", str(out), "--no-pictures"]) == 0
    assert "The moment nearest to failure is not all there: " in (out / "report.html").read_text()


def test_the_picture_of_the_worst_moment_marks_it(out, capfd):
    assert main(["recover", str(out), "--worst"]) == 0
    printed = capfd.readouterr()
    if "there is no picture" in printed.err:
        pytest.skip(printed.err)
    assert printed.out.splitlines()[-1] == f"{out}/worst.json, {out}/worst.png"
    from PIL import Image

    image = np.asarray(Image.open(out / "worst.png").convert("RGB"), dtype=int)
    assert image.shape == (900, 1600, 3)
    for half in (image[:360], image[360:]):  # each with the mark, which is dark blue
        assert (np.abs(half - (11, 61, 145)).max(axis=2) < 40).sum() > 20


def test_places_and_gauges_are_written_and_described(out, capfd):
    place = ["--at", "0.4,spar_cap_suction_side,1"]
    assert main(["recover", str(out), *place, "--set", "output.gauges.new.station=0.6"]) == 0
    head, first, *_, paths = capfd.readouterr().out.splitlines()
    assert head.startswith("spar_cap_suction_side, the cell ") and first.startswith("  ply 1: ")
    file = "at_0.4_spar_cap_suction_side_ply_1.csv"
    assert paths == f"{out}/gauges.csv, {out}/{file}"
    assert list(read_columns(out, "gauges.csv")) == [
        *("time_[s]", "strain_root_[-]", "strain_new_[-]")
    ]
    assert len(read_columns(out, file)) == 1 + 3 * 7
    is_refused(["recover", str(out), *place], capfd, f"{file}' is there already")
    is_refused(["recover", str(out), "--gauges"], capfd, "gauges.csv' is there already")


def test_fields_are_those_that_are_named_at_equal_times(out):
    pytest.importorskip("h5py")
    command = ["recover", str(out), "--fields", "velocity,maximum_stress", "--every", "0.2s"]
    assert main([*command, "--from", "0.1", "--quiet"]) == 0
    with VtkHdfFile(out / "fields.vtkhdf") as file:
        assert file.times == pytest.approx([0.1, 0.3, 0.5])
        step = file.read(2)
    assert set(step.point_data) == {"displacement", "velocity", "coupling"}
    assert set(step.cell_data) == {"maximum_stress", "part"}


def test_an_interrupt_leaves_the_fields_that_are_written(out, monkeypatch):
    pytest.importorskip("h5py")
    write, count = Fields.write, iter(range(10))

    def end(self, *values):
        if next(count) == 3:
            raise KeyboardInterrupt
        write(self, *values)

    monkeypatch.setattr(Fields, "write", end)
    assert main(["recover", str(out), "--fields", "displacement", "--every", "0.1"]) == 130
    with VtkHdfFile(out / "fields.vtkhdf") as file:
        assert file.times == pytest.approx([0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--fields", "tsai_w"], "did you mean 'tsai_wu'?"),
        (["--fields", "--times", "9"], "t = 9 s is outside of the motion, which is from 0 s"),
        (["--fields", "--times", "max(tip)"], "'tip' is neither a failure criterion nor"),
        (["--fields", "--every", "0"], "--every 0: expected a positive number"),
        (["--fields", "--every", "x"], "--every x: give numbers"),
        (["--fields", "--every", "1,2"], "--every 1,2: give one number"),
        (["--fields", "--from", "1"], "--from 1: counts with --every only"),
        (["--times", "1"], "--times 1: counts with --fields only"),
        (["--at", "0.4"], "place '0.4': expected STATION,PANEL or STATION,PANEL,PLY"),
        (["--at", "2,web"], "place '2,web': expected STATION,PANEL"),
        (["--at", "0.4,spar_cap_suction_sid"], "did you mean 'spar_cap_suction_side'?"),
        (["--at", "0.4,spar_cap_suction_side,99"], "there is no ply 99 in spar_cap_suction_side"),
        (["--set", "time.end=9"], "--set time.end=9: only output.gauges.NAME can be set"),
        (["--set", "output.gauges.new.station=9"], "output.gauges.new.station = 9: must be less"),
    ],
)
def test_wrong_options_are_one_sentence_and_write_nothing(out, capfd, options, words):
    pytest.importorskip("h5py")
    is_refused(["recover", str(out), *options], capfd, words)
    assert not (out / "fields.vtkhdf").exists()


def test_fields_without_h5py_are_refused_before_work(out, capfd, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    is_refused(["recover", str(out), *FIELDS], capfd, "need h5py")


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
    is_refused(
        ["recover", str(out)],
        capfd,
        "motion.bin' does not belong to",
        "functions, or numbers of copies, of their bases differ",
    )


def test_a_run_without_reduced_blades_is_told_where_its_fields_are(out, capfd):
    case = json.loads((out / "case.json").read_text())
    case["blade"]["model"] = "full"
    (out / "case.json").write_text(json.dumps(case))
    is_refused(["recover", str(out)], capfd, "no part of", "fields.xdmf")


@pytest.mark.parametrize("name", ["motion.bin", "motion.json"])
def test_a_missing_motion_is_named(out, capfd, name):
    (out / name).unlink()
    is_refused(["recover", str(out)], capfd, f"{name}': No such file or directory")


def test_a_folder_without_a_run_is_refused(tmp_path, capfd):
    is_refused(["recover", str(tmp_path)], capfd, "there is no run in")
    is_refused(["recover", str(tmp_path / "none")], capfd, "there is no output folder")
