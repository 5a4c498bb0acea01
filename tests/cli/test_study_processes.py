"""Runs of a study as processes: how many, why they fail, and how they are ended."""

import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from turbine_fenicsx.study import execute
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import plan
from turbine_fenicsx.study.results import RESULTS

RIGID = Path(__file__).parents[2] / "demos" / "paper" / "rigid.toml"


@pytest.fixture
def fake_runs(tmp_path, monkeypatch):
    """Runs whose children write empty results and are then given python code."""
    path = tmp_path / "study.toml"
    path.write_text(f"case = '{RIGID}'\n[grid]\ntime.end = [1, 2, 3, 4, 5]")
    runs = plan(Study.load(path))

    def start(run, folder, launcher, change=""):
        folder.mkdir(parents=True, exist_ok=True)
        for name in start.results:
            (folder / name).touch()
        code = f"folder = {str(folder)!r}; end = {run.value('time.end')}; change = {change!r}\n"
        code += start.code
        with (folder / execute.LOG).open("wb") as log:
            return subprocess.Popen(
                [sys.executable, "-c", code], stdout=log, stderr=log, start_new_session=True
            )

    start.results = RESULTS
    monkeypatch.setattr(execute, "_start", start)
    return runs, tmp_path / "out", start


def test_no_more_than_the_given_number_of_processes_run_at_a_time(fake_runs):
    runs, out, start = fake_runs
    start.code = (
        "import time; t = time.time(); time.sleep(0.3);"
        " open(folder + '/span', 'w').write(f'{t} {time.time()}')"
    )
    outcomes = []
    execute.execute(runs, out, 2, [], outcomes.append)
    spans = np.array([list(map(float, p.read_text().split())) for p in out.glob("*/span")])
    assert len(spans) == len(outcomes) == 5
    at_a_time = [int(np.sum((spans[:, 0] <= t) & (t < spans[:, 1]))) for t in spans[:, 0]]
    assert max(at_a_time) == 2
    assert all(not outcome.reason and outcome.seconds >= 0.3 for outcome in outcomes)


def test_reason_of_a_failure_is_what_the_run_said_last(fake_runs):
    runs, out, start = fake_runs
    start.code = (
        "import os, sys\n"
        "if end == 2: print('error: one\\nerror: two'); sys.exit(2)\n"
        "if end == 3: os.kill(os.getpid(), 9)\n"
        "if end == 4: raise MemoryError('too large')\n"
        "if end == 5: sys.exit(7)\n"
    )
    reasons = {}
    execute.execute(runs, out, 5, [], lambda o: reasons.update({o.run.value("time.end"): o.reason}))
    assert reasons == {
        1: "",
        2: "wrong input: one; two",
        3: "killed by signal 9",
        4: "exit code 1: MemoryError: too large",
        5: "exit code 7",
    }


def test_runs_whose_steps_fail_have_a_second_try_with_half_the_step(fake_runs):
    runs, out, start = fake_runs
    start.code = (
        "import sys\n"
        "open(folder + '/tries', 'a').write(f'{change} ')\n"
        "if end == 1: sys.exit(2)\n"
        "if end == 2 and not change: sys.exit(3)\n"
        "if end == 3: sys.exit(4)\n"
    )
    reasons = {}

    def note(outcome):
        reasons[outcome.run.value("time.end")] = outcome.reason

    execute.execute(runs, out, 2, [], note, retry=True)
    half = 0.5 * runs[0].case.time.step
    tries = {run.value("time.end"): (out / run.name / "tries").read_text() for run in runs}
    twice = f" time.step={half!r} "
    assert tries == {1: " ", 2: twice, 3: twice, 4: " ", 5: " "}
    wrong = "the energy balance is wrong"
    assert reasons == {1: "wrong input", 2: "", 3: wrong, 4: "", 5: ""}


def test_runs_without_a_start_have_a_second_try_with_wind_that_sets_in(fake_runs):
    runs, out, start = fake_runs
    start.results = ()
    start.code = "import sys; print(change); sys.exit(0 if 'ramp' in change else 3)"
    case = runs[0].case
    wind = case.wind.model_copy(update={"speed": 8.0})
    windy = replace(runs[0], case=case.model_copy(update={"wind": wind}))
    execute.execute([windy, runs[1]], out, 2, [], lambda outcome: None, retry=True)
    said = [(out / run.name / execute.LOG).read_text().strip() for run in runs[:2]]
    assert said == ["wind.ramp=5.0", f"time.step={0.5 * runs[1].case.time.step!r}"]


NO_SLOTS = """
--------------------------------------------------------------------------
There are not enough slots available in the system to satisfy the 64
slots that were requested by the application:

  /usr/bin/python3
--------------------------------------------------------------------------
"""
ABORTED = "ImportError: no \x1b[31mpetsc\n----\nPrimary job terminated normally.\n----\n"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            NO_SLOTS,
            "There are not enough slots available in the system to satisfy the 64 slots that were "
            "requested by the application:",
        ),
        (ABORTED, r"ImportError: no \x1b[31mpetsc"),
        ("-----\n", ""),
    ],
)
def test_a_launcher_that_fails_is_not_quoted_by_its_banner(fake_runs, text, reason):
    runs, out, start = fake_runs
    start.code = f"import sys; print({text!r}, end=''); sys.exit(1)"
    outcomes = []
    execute.execute(runs[:1], out, 1, [], outcomes.append)
    assert outcomes[0].reason == (f"exit code 1: {reason}" if reason else "exit code 1")


def test_run_that_ends_well_without_results_has_failed(fake_runs):
    runs, out, start = fake_runs
    start.code, start.results = "pass", ["history.csv"]
    outcomes = []
    execute.execute(runs[:1], out, 1, [], outcomes.append)
    assert outcomes[0].reason == "the launcher ended without writing summary.json"


def test_children_that_do_not_end_are_killed(fake_runs, monkeypatch):
    runs, out, start = fake_runs
    monkeypatch.setattr(execute, "_PATIENCE", 0.5)
    started = []
    start.code = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN)\n" + (
        "open(folder + '/ready', 'w').close(); time.sleep(60)"
    )
    popen = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda *a, **k: started.append(popen(*a, **k)) or started[-1]
    )
    sleep, begin = time.sleep, time.monotonic()

    def interrupted(seconds):
        sleep(seconds)
        if len(list(out.glob("*/ready"))) == 2 and not interrupted.done:
            interrupted.done = True
            raise KeyboardInterrupt

    interrupted.done = False
    monkeypatch.setattr(execute.time, "sleep", interrupted)
    with pytest.raises(KeyboardInterrupt):
        execute.execute(runs, out, 2, [], lambda outcome: None)
    assert time.monotonic() - begin < 30.0
    assert [process.returncode for process in started] == [-signal.SIGKILL] * 2
