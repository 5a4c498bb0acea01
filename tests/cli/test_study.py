"""The command ``study``: parallel runs, reruns, failures, interrupts, tables, orders."""

import csv
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from patience import patience

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.study import execute
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import plan

ROOT = Path(__file__).parents[2]
RIGID = ROOT / "demos" / "paper" / "rigid.toml"
DEMO = ROOT / "demos" / "studies" / "time_step.toml"


def table(path):
    """Rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_study(folder, text, name="study.toml"):
    """A study of the rigid turbine, a tenth of a second unless the text says otherwise."""
    path = folder / name
    path.write_text(f"case = '{RIGID}'\n{text}\n[set]\noutput.fields_every = 0\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def demo_study(command_line, tmp_path_factory):
    """The demo, shorter and coarser; its output folder, its file and the finished process."""
    folder = tmp_path_factory.mktemp("demo")
    text = DEMO.read_text(encoding="utf-8").replace("../paper/rigid.toml", str(RIGID))
    text, n = re.subn(r"time.step = \[.*\]", "time.step = [0.05, 0.025, 0.0125]", text)
    assert n == 1
    path = folder / "time_step.toml"
    path.write_text(text, encoding="utf-8")
    result = command_line("study", path, "-o", folder / "out", "--set", "time.end=0.5")
    assert result.returncode == 0, result.stderr
    return folder / "out", path, result


def test_demo_observes_the_second_order_of_the_step(demo_study):
    out, _, result = demo_study
    orders = [float(x) for x in re.findall(r"observed order: ([0-9.]+)", result.stdout)]
    # three runs of 10, 20 and 40 steps; measured 2.00 and 1.97
    assert orders == pytest.approx([2.0, 2.0], abs=0.05)
    rows = table(out / "convergence.csv")
    assert len(rows) == 6
    assert {row["quantity"] for row in rows} == {"angle_rotor_[rad]", "kinetic_energy_[J]"}
    assert (out / "convergence.png").stat().st_size > 10_000


def test_table_has_a_row_for_each_run_and_the_wanted_columns(demo_study):
    out, _, _ = demo_study
    rows = table(out / "study.csv")
    assert [row["state"] for row in rows] == ["finished"] * 3
    assert [float(row["time.step"]) for row in rows] == [0.05, 0.025, 0.0125]
    assert list(rows[0]) == [
        "run",
        "state",
        "time.step",
        "angle_rotor_[rad]",
        "angle_yaw_[rad]",
        "kinetic_energy_[J]",
        "worst_energy_error_[J]",
        "wall_time_[s]",
    ]
    for row in rows:
        folder = out / row["run"]
        last = table(folder / "history.csv")[-1]
        summary = json.loads((folder / "summary.json").read_text())
        assert float(last["time_[s]"]) == pytest.approx(0.5, abs=1e-15)
        assert row["angle_rotor_[rad]"] == last["angle_rotor_[rad]"]
        assert float(row["wall_time_[s]"]) == summary["wall_time_[s]"]
        assert "steps" in (folder / "log.txt").read_text()


def test_progress_is_on_stderr_and_results_on_stdout(demo_study):
    _, _, result = demo_study
    lines = result.stderr.splitlines()
    assert [line.split()[0] for line in lines] == ["1/3", "2/3", "3/3"]
    assert all("finished in" in line for line in lines)
    assert "3 of 3 runs finished" in result.stdout


def test_second_call_runs_only_what_is_new_or_changed(demo_study, command_line, capfd):
    out, path, _ = demo_study
    before = {p: p.stat().st_mtime_ns for p in out.glob("*/summary.json")}
    assert len(before) == 3
    text = path.read_text(encoding="utf-8").replace("[0.05,", "[0.1, 0.05,")
    path.write_text(text, encoding="utf-8")
    result = command_line("study", path, "-o", out, "--set", "time.end=0.5")
    assert result.returncode == 0, result.stderr
    assert result.stderr.count("was finished before") == 3
    assert result.stderr.count("finished in") == 1
    assert {p: p.stat().st_mtime_ns for p in before} == before
    assert len(table(out / "study.csv")) == 4
    # another end time is another case for all of them
    for end, state in (("0.4", "to run"), ("0.5", "finished")):
        assert main(["study", str(path), "-o", str(out), "--list", "--set", f"time.end={end}"]) == 0
        listed = capfd.readouterr().out.splitlines()
        assert [line.split("  ")[0] for line in listed] == [state] * 4


def test_failed_run_does_not_stop_the_others(command_line, tmp_path):
    path = write_study(
        tmp_path,
        "processes = 2\n[grid]\ntime.end = [0.04]\nloads.rotor_torque = [1e22, -1e6]",
    )
    result = command_line("study", path, "-o", tmp_path / "out")
    assert result.returncode == 3
    assert "Traceback" not in result.stderr
    (sentence,) = (s for s in result.stderr.splitlines() if s.startswith("error: "))
    assert "time.end=0.04,loads.rotor_torque=1e+22" in sentence
    assert "a step did not converge" in sentence
    rows = table(tmp_path / "out" / "study.csv")
    assert [row["state"] for row in rows] == ["failed", "finished"]
    # all numbers of the summary and of the last row
    assert float(rows[1]["masses_[kg].hub"]) == 61e3
    assert rows[0]["masses_[kg].hub"] == ""
    assert float(rows[1]["time_[s]"]) == 0.04


@pytest.fixture(scope="module")
def interrupted(command_line, tmp_path_factory):
    """A study that was interrupted: its file, its folder, and how far its runs have come [s]."""
    tmp_path = tmp_path_factory.mktemp("interrupted")
    text = "processes = 2\n[grid]\ntime.end = [0.04, 1000, 1001, 1002]"
    path, out = write_study(tmp_path, text), tmp_path / "out"
    command = [sys.executable, "-m", "turbine_fenicsx", "study", str(path), "-o", str(out)]
    command.append("--overwrite")
    running = [out / f"time.end={end}" / "history.csv" for end in (1000, 1001)]
    running[0].parent.mkdir(parents=True)  # with a result of another case
    (running[0].parent / "case.toml").write_text("time.end = 999\n")
    (running[0].parent / "summary.json").write_text("{}\n")
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=ROOT) as process:
        try:
            start = time.monotonic()
            while not all(p.exists() and p.read_text().count("\n") > 10 for p in running):
                assert process.poll() is None, process.stderr.read()
                assert time.monotonic() - start < patience(60.0)
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=patience(30))
        finally:
            process.terminate()
    assert process.returncode == 130
    assert errors.splitlines()[-1].startswith("error: interrupted")
    assert "Traceback" not in errors
    # the children have ended, by themselves
    reached = {}
    for history in running:
        assert "error: interrupted" in (history.parent / "log.txt").read_text()
        reached[history.parent.name] = float(table(history)[-1]["time_[s]"])
    states = [row["state"] for row in table(out / "study.csv")]
    assert states == ["finished", "not run", "not run", "not run"]
    listed = command_line("study", path, "-o", out, "--list").stdout.splitlines()
    assert [line.split("  ")[0] for line in listed] == [
        "finished",
        "to resume",
        "to resume",
        "to run",
    ]
    return path, out, reached


@pytest.mark.slow
def test_interrupted_runs_go_on(interrupted, command_line):
    path, out, reached = interrupted
    command = [sys.executable, "-m", "turbine_fenicsx", "study", str(path), "-o", str(out)]
    name, before = next(iter(reached.items()))
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, cwd=ROOT) as process:
        try:
            start = time.monotonic()
            while float(table(out / name / "history.csv")[-1]["time_[s]"]) < before + 1.0:
                assert process.poll() is None
                assert time.monotonic() - start < patience(60.0)
                time.sleep(0.1)
            process.send_signal(signal.SIGTERM)  # as a batch system does
            # a run that is still being imported may miss the signal, and is killed after a minute
            assert process.wait(timeout=patience(90)) == 130
        finally:
            process.terminate()
    times = [float(row["time_[s]"]) for row in table(out / name / "history.csv")]
    assert times[0] == 0.0
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, 0.02), abs=1e-9)


def test_ranks_of_each_run(command_line, tmp_path, monkeypatch):
    if shutil.which("mpirun") is None:
        pytest.skip("there is no mpirun")
    for name, value in {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "PRTE_MCA_mapby": ":oversubscribe",
    }.items():
        monkeypatch.setenv(name, value)
    path = write_study(tmp_path, "ranks = 2\n[grid]\ntime.end = [0.04]")
    result = command_line("study", path, "-o", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    assert float(table(tmp_path / "out" / "study.csv")[0]["ranks"]) == 2.0


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("[grid]\ntime.step = [0, -1]", [], ["time.step = 0:", "time.step = -1:"]),
        ("[grid]\ntime.end = [1]", ["-j", "0"], ["--processes 0: must be at least 1"]),
        ("[grid]\ntime.end = [1]", ["--set", "time.stp=1"], ["did you mean 'time.step'?"]),
        (
            "ranks = 2\nlauncher = 'no_such_mpirun -n {ranks}'\n[grid]\ntime.end = [1]",
            [],
            ["launcher = 'no_such_mpirun -n {ranks}': there is no such program"],
        ),
        (
            """ranks = 2\nlauncher = 'mpirun "-n {ranks}'\n[grid]\ntime.end = [1]""",
            [],
            ["a quotation mark is not closed"],
        ),
        (f"[grid]\ntime.end = {'[' * 5000}", [], ["nested too deeply"]),
        (f"[grid]\n{'.'.join(['a'] * 5000)} = [1]", [], ["nested too deeply"]),
        (f"[grid]\ntime.end = [{'9' * 5000}]", [], ["too many digits"]),
        (
            f"[grid]\ntime.end = {[1.0 + k for k in range(101)]}\nloads.gravity = {[*range(100)]}",
            [],
            ["the study has 10100 runs, expected at most 10000"],
        ),
    ],
)
def test_wrong_study_is_refused_before_anything_runs(tmp_path, capfd, text, options, words):
    path, out = write_study(tmp_path, text), tmp_path / "out"
    assert main(["study", str(path), "-o", str(out), *options]) == 2
    output, errors = capfd.readouterr()
    assert output == ""
    lines = errors.splitlines()
    assert len(lines) == len(words)
    for line, word in zip(lines, words, strict=True):
        assert line.startswith("error: ")
        assert word in line
    assert not out.exists()


def test_study_under_mpirun_is_refused(command_line):
    result = command_line("study", DEMO, ranks=2)
    assert result.returncode == 2
    assert result.stderr.count("error: start a study without mpirun") == 1


def test_means_that_drift_are_named_once_for_all_runs(tmp_path, capfd):
    path = write_study(
        tmp_path,
        "average = 0.2\nquantities = ['angle_rotor', 'energy_error']\n"
        "[grid]\ntime.step = [0.02, 0.05]\ntime.end = [0.2]",
    )
    assert main(["study", str(path), "-o", str(tmp_path / "out")]) == 0
    (note,) = (line for line in capfd.readouterr().out.splitlines() if line.startswith("note"))
    assert re.fullmatch(
        r"note: angle_rotor is not stationary in 2 of 2 runs, most 'time.step=0.0[25],.*': its "
        r"means over the two halves of the last 0.2 s differ by \d+(\.\d)? %",
        note,
    )


def test_quantity_that_no_run_writes_is_refused_before_anything_runs(tmp_path, capfd):
    # a thousand years would not end before the test does
    text = "quantities = ['kinetic_energy', 'kinetic_enrgy']\n[grid]\ntime.end = [1e7, 2e7]"
    assert main(["study", str(write_study(tmp_path, text)), "-o", str(tmp_path / "out")]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.endswith("is none that a run writes; did you mean 'kinetic_energy'?")
    assert not (tmp_path / "out").exists()


def test_quantity_that_these_runs_do_not_write_is_told_after_the_first(command_line, tmp_path):
    text = "quantities = ['tip_flap_1']\n[grid]\ntime.end = [0.04, 1e7]\nturbine.model = ['rigid']"
    result = command_line("study", write_study(tmp_path, text), "-o", tmp_path / "out")
    assert result.returncode == 2
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("error")]
    assert "quantity 'tip_flap_1' is none of" in line


def test_what_a_folder_holds_decides_how_its_run_starts(tmp_path, monkeypatch):
    (run,) = plan(Study.load(write_study(tmp_path, "[grid]\ntime.end = [1]")))
    commands = []
    monkeypatch.setattr(subprocess, "Popen", lambda command, **_: commands.append(command))
    case, summary = tmp_path / "case.toml", tmp_path / "summary.json"
    for text, left, task in (
        (None, None, "run"),
        ("time.end = 2", "{}", "run"),
        (run.text, '{"interrupted": true}', "restart"),
        (run.text, '{"interr', "run"),
    ):
        if text:
            case.write_text(text)
            summary.write_text(left)
        execute._start(run, tmp_path, ["mpirun", "-n", "2"])
        # or a run that is killed would count as finished
        assert not summary.exists()
        assert case.read_text() == run.text
        assert commands[-1][:3] == ["mpirun", "-n", "2"]
        assert commands[-1][commands[-1].index("turbine_fenicsx") + 1] == task
