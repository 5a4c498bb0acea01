"""Whatever a controller of a user does, a run ends with a sentence, a checkpoint and its code."""

import csv
import json

import pytest

from turbine_fenicsx.cli.main import main

CASE = """
[turbine]
model = "rigid"
rotor_speed = "12 rpm"
[pitch]
drive = "actuator"
[control]
kind = "python:mine.py:Mine"
[time]
step = 0.05
end = {end}
[output]
fields_every = 0
"""
MINE = """
import sys

class Mine:
    def __call__(self, measured):
        if measured.time > 0.14:
            {call}
        return 10.0, (0.0, 0.0, 0.0)

    def finish(self):
        {finish}
"""
STEPS = 3


def write(folder, call="pass", finish="pass", end=0.3):
    """A case with its controller."""
    (folder / "mine.py").write_text(MINE.format(call=call, finish=finish))
    case = folder / "case.toml"
    case.write_text(CASE.format(end=end))
    return case


def rows(folder):
    """Times of ``history.csv``."""
    with (folder / "history.csv").open(newline="") as file:
        return [float(row[0]) for row in list(csv.reader(file))[1:]]


@pytest.mark.parametrize(
    ("call", "what", "ranks"),
    [
        ("sys.exit(5)", "failed at t = 0.15 s: SystemExit: 5 (line 7)", 2),
        ("raise BaseException('x')", "failed at t = 0.15 s: BaseException: x (line 7)", None),
        (
            "return 10**400, (0.0, 0.0, 0.0)",
            "must return Commands(generator_torque, pitch, yaw_rate, brake), got (1000",
            None,
        ),
    ],
)
def test_a_controller_that_fails_ends_the_run_with_a_sentence_and_a_checkpoint(
    command_line, tmp_path, call, what, ranks
):
    case, out = write(tmp_path, call), tmp_path / "out"
    result = command_line("run", case, "-o", out, "--quiet", ranks=ranks)
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1
    assert errors[0].startswith(f"error: the controller 'Mine' of '{tmp_path / 'mine.py'}' {what}")
    assert "Traceback" not in result.stderr
    assert result.returncode == 2
    assert (out / "checkpoints" / f"checkpoint_{STEPS:08d}.npz").exists()
    assert len(rows(out)) == STEPS + 1
    again = command_line("restart", out, "--quiet")
    assert again.returncode == 2 and what in again.stderr


def test_a_finish_that_fails_is_a_warning_and_the_results_are_complete(command_line, tmp_path):
    case, out = write(tmp_path, finish="sys.exit(5)", end=0.1), tmp_path / "out"
    result = command_line("run", case, "-o", out, "--quiet", ranks=2)
    assert result.returncode == 0, result.stderr
    who = f"finish() of the controller 'Mine' of '{tmp_path / 'mine.py'}'"
    sentence = f"{who} failed, the results are complete: SystemExit: 5 (line 11)"
    assert result.stderr.splitlines().count(f"warning: {sentence}") == 1
    assert sentence in (out / "run.log").read_text()
    assert json.loads((out / "summary.json").read_text())["steps"] == 2
    assert len(rows(out)) == 3


SAVING = """
    def save(self):
        {save}

    def restore(self, data):
        pass
"""


def test_a_save_that_fails_at_the_start_leaves_a_checkpoint(command_line, tmp_path):
    """What it would have saved is not needed: it is shown again what it saw."""
    case, out = write(tmp_path), tmp_path / "out"
    with (tmp_path / "mine.py").open("a") as file:
        file.write(SAVING.format(save="open(__file__ + '\\x1b[31m').read()"))
    result = command_line("run", case, "-o", out, "--quiet")
    assert result.returncode == 2
    assert "save() of the controller 'Mine' of " in result.stderr
    assert r"failed: FileNotFoundError: [Errno 2] No such file" in result.stderr
    assert r"mine.py\x1b[31m' (line" in result.stderr
    assert [p.name for p in (out / "checkpoints").iterdir()] == ["checkpoint_00000000.npz"]
    (tmp_path / "mine.py\x1b[31m").touch()
    again = command_line("restart", out, "--quiet")
    assert again.returncode == 0, again.stderr
    assert len(rows(out)) == 7


def test_a_controller_that_changes_the_folder_does_not_move_the_results(tmp_path, monkeypatch):
    case = write(tmp_path, "__import__('os').chdir('/')")
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(case), "-o", "there", "--quiet"]) == 0
    assert (tmp_path / "there" / "summary.json").exists()
    assert len(rows(tmp_path / "there")) == 7
