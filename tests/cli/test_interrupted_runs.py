"""However a run ends, it can go on, and then it is the run that never ended."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from patience import patience

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.output_folder import holds_run, read_field_times, read_history
from turbine_fenicsx.turbine.run.run import restart_case

ROOT = Path(__file__).parents[2]
RIGID = ("output.fields_every=0.1", "output.checkpoint_every=0.06")
HYBRID = ("mesh.elements=[1,1,4]", "output.fields_every=0.04", "output.checkpoint_every=0.06")


def rows(folder):
    """Complete lines of ``history.csv`` without the wall time; none if there is no file yet."""
    try:
        lines = (folder / "history.csv").read_text().splitlines(keepends=True)
    except FileNotFoundError:
        return []
    return [line.rsplit(",", 1)[0] for line in lines if line.endswith("\n")]


def assert_whole(folder, whole, n=None):
    """The first rows are those of another run bit for bit; all if there is no number."""
    expected = rows(whole)[:n]
    assert rows(folder) == expected
    times = [float(row.split(",")[0]) for row in expected[1:]]
    text = (folder / "history.out").read_text().splitlines()
    assert text == (whole / "history.out").read_text().splitlines()[: len(text)]
    assert len(text) == 8 + len(times) - 1
    assert (folder / "fields.xdmf").read_text().rstrip().endswith("</Xdmf>")
    found = read_field_times(folder / "fields.xdmf")
    assert np.all(np.diff(found) > 0.0)
    assert found[-1] == times[-1]


class Run:
    """A run in a process of its own, so that it can be interrupted; for ``with``."""

    def __init__(self, command, arguments, ranks=None, launcher=None):
        self.command = [sys.executable, "-m", "turbine_fenicsx", command, *map(str, arguments)]
        self.environment = dict(os.environ)
        if ranks is not None:
            program, settings = launcher
            self.command = [program, "-n", str(ranks), *self.command]
            self.environment = settings | self.environment

    def __enter__(self):
        self.process = subprocess.Popen(
            self.command,
            env=self.environment,
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        return self

    def __exit__(self, *error):
        self.process.kill()
        self.process.communicate()

    def wait_for(self, condition, seconds=60.0):
        """Wait until something is so; the process must be alive."""
        start = time.monotonic()
        while not condition():
            if self.process.poll() is not None:
                raise AssertionError(self.process.stderr.read())
            assert time.monotonic() - start < patience(seconds)
            time.sleep(0.01)

    def finish(self, seconds=60.0):
        """Wait for the end: exit code, and lines on stderr."""
        out, err = self.process.communicate(timeout=patience(seconds))
        # MPICH's mpiexec speaks of Ctrl-C there
        assert all(line.startswith("[mpiexec@") for line in out.splitlines()), out
        return self.process.returncode, err.splitlines()


@pytest.fixture(scope="module")
def reference(tmp_path_factory, demo):
    """Uninterrupted runs, much longer than the others."""
    folder = tmp_path_factory.mktemp("reference")
    for name, end, changes in (("rigid", 8.0, RIGID), ("hybrid_soft", 2.0, HYBRID)):
        arguments = ["-o", str(folder / name), "--quiet", "--set", f"time.end={end}", *changes]
        assert main(["run", str(demo(f"{name}.toml")), *arguments]) == 0
    return folder


@pytest.fixture
def launcher(command_line):
    """mpirun and its environment, as the other tests of the command line use it."""
    return command_line.__globals__["mpirun"]()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_run_after_the_step_and_says_how_to_go_on(
    demo, tmp_path, reference, number, capfd
):
    out = tmp_path / "my runs" / "first"
    case = [demo("rigid.toml"), "-o", out, "--quiet", "--set", "time.end=1000", *RIGID]
    with Run("run", case) as run:
        run.wait_for(lambda: len(rows(out)) > 5)
        run.process.send_signal(number)
        code, (sentence,) = run.finish()
    assert code == 130
    found = re.fullmatch(
        r"error: interrupted at t = (\S+) s; `turbine-fenicsx (.*)` resumes from there", sentence
    )
    assert found, sentence
    n = len(rows(out))
    assert float(found[1]) == pytest.approx(0.02 * (n - 2), rel=1e-5)
    newest = max((out / "checkpoints").iterdir())
    assert newest.name == f"checkpoint_{n - 2:08d}.npz"  # of the very last step
    assert json.loads((out / "summary.json").read_text())["interrupted"] is True
    # the command is what one would paste
    command = shlex.split(found[2])
    end = f"time.end={0.02 * (n + 8):.2f}"
    assert main([*command, "--quiet", "--set", end]) == 0
    assert len(rows(out)) == n + 10
    assert rows(out) == rows(reference / "rigid")[: n + 10]
    capfd.readouterr()


IMPORTING = """
import os, sys
number, name = int(sys.argv.pop(1)), sys.argv.pop(1)

class Finder:
    def find_spec(self, wanted, *_):
        if wanted == name:
            os.kill(os.getpid(), number)

sys.meta_path.insert(0, Finder())
from turbine_fenicsx.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    ("number", "name"),
    [
        (signal.SIGINT, "turbine_fenicsx.cli.commands.run"),
        (signal.SIGINT, "dolfinx"),
        (signal.SIGTERM, "petsc4py"),
        (signal.SIGHUP, "turbine_fenicsx.cli.commands.run"),
        (signal.SIGUSR1, "petsc4py"),
    ],
)
def test_a_signal_during_imports_ends_quietly(demo, tmp_path, number, name):
    """So that what sends it, such as a batch system, reads the code of an interrupt."""
    arguments = ["run", demo("hybrid_soft.toml"), "-o", tmp_path / "out", "--quiet"]
    command = [sys.executable, "-c", IMPORTING, str(number.value), name, *map(str, arguments)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.stderr == "error: interrupted; what was written so far is complete\n"
    assert result.returncode == 130


def test_a_terminal_that_is_closed_does_not_end_what_nohup_started(demo, tmp_path):
    case = [demo("rigid.toml"), "-o", tmp_path, "--quiet", "--set", "time.end=0.6", *RIGID]
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Run("run", case) as run:
            run.wait_for(lambda: len(rows(tmp_path)) > 2)
            run.process.send_signal(signal.SIGHUP)
            assert run.finish() == (0, [])
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_signal_while_the_run_starts_is_not_lost(demo, tmp_path):
    """It ends the run before the first step, which leaves nothing that a new run would replace, or
    where the run is faster than the signal after it."""
    case = [demo("hybrid_soft.toml"), "-o", tmp_path, "--quiet", "--set", *HYBRID]
    with Run("run", case) as run:
        run.wait_for(lambda: (tmp_path / "run.log").exists())
        run.process.send_signal(signal.SIGTERM)
        code, (sentence,) = run.finish()
    assert code == 130
    steps = sentence.startswith("error: interrupted at t = ")
    assert steps or sentence == "error: interrupted; what was written so far is complete"
    assert holds_run(tmp_path) == steps


@pytest.mark.slow
def test_a_run_that_is_killed_at_any_moment_can_go_on(demo, tmp_path, comm):
    """Twenty kills, one after another: some while the program starts, some in the run."""
    random, out = np.random.default_rng(20), tmp_path / "out"
    kills = resumed = 0
    fresh = [demo("rigid.toml"), "-o", out, "--quiet", "--set", "time.end=1000", *RIGID]
    while kills < 20:
        again = any((out / "checkpoints").glob("*.npz")) if out.exists() else False
        before = (out / "run.log").stat().st_size if (out / "run.log").exists() and again else 0
        with Run(*(("restart", [out, "--quiet"]) if again else ("run", fresh))) as run:
            if random.uniform() < 0.3:  # anywhere from the first import to the first steps
                time.sleep(random.uniform(0.0, 1.2))
            else:
                size = before + int(random.integers(200, 3000))  # up to some twenty lines
                log = out / "run.log"
                run.wait_for(lambda log=log, size=size: log.exists() and log.stat().st_size > size)
                time.sleep(random.uniform(0.0, 0.01))
            assert run.process.poll() is None, run.process.stderr.read()
            run.process.send_signal(signal.SIGKILL)
            run.process.wait()
        kills += 1
        resumed += again
    assert resumed >= 10
    end = 0.02 * (len(rows(out)) + 3)
    restart_case(out, comm, [f"time.end={end:.2f}"], "none")
    n = len(rows(out))
    assert n == round(end / 0.02) + 2
    assert n > 30
    whole = tmp_path / "whole"
    fresh[fresh.index(out)], fresh[fresh.index("time.end=1000")] = whole, f"time.end={end:.2f}"
    assert main(["run", *map(str, fresh)]) == 0
    assert rows(out) == rows(whole)
    steps = (out / "history.out").read_text().splitlines()
    assert steps == (whole / "history.out").read_text().splitlines()
    assert len(steps) == 8 + n - 2
    assert np.all(np.diff(read_field_times(out / "fields.xdmf")) > 0.0)
    assert len(list((out / "checkpoints").iterdir())) == 2


KILLER = """
import os, sys, time
moment, out = int(sys.argv.pop(1)), sys.argv.pop(1)
count = 0

def at_every_change_of_a_file(event, arguments):
    global count
    if event not in ("open", "os.rename", "os.remove", "os.truncate", "os.mkdir"):
        return
    if not str(arguments[0]).startswith(out):
        return
    if event == "open" and not arguments[2] & (os.O_WRONLY | os.O_RDWR):
        return
    if count == moment:
        os.kill(os.getpid(), 9)
    count += 1

from turbine_fenicsx.cli.main import main
import turbine_fenicsx.turbine.run.run
sys.addaudithook(at_every_change_of_a_file)
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
def test_a_run_that_is_killed_before_any_change_of_a_file_can_go_on(
    demo, tmp_path, reference, comm
):
    """Each kill is some changes of files later than the last. Where there is no checkpoint yet, a
    new run begins; else nothing is lost but what comes after the last one."""
    out, whole = tmp_path / "out", rows(reference / "rigid")
    fresh = ["run", demo("rigid.toml"), "-o", out, "--quiet", "--set", "time.end=0.08", *RIGID]

    def killed(moment, *arguments):
        """Whether the program was killed, and not done before."""
        command = [sys.executable, "-c", KILLER, str(moment), str(out), *map(str, arguments)]
        result = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, timeout=patience(60)
        )
        assert result.returncode in (0, -signal.SIGKILL), result.stderr
        assert not result.stderr
        return result.returncode != 0

    moment = 0
    while not any((out / "checkpoints").glob("*.npz")):
        assert killed(moment, *fresh)
        moment += 4
    assert 4 <= moment <= 60  # or it counts changes of files of something else
    moment = done = 0
    while killed(moment, "restart", out, "--quiet", "--set", f"time.end={0.08 + 0.02 * done:.2f}"):
        moment += 4
        done += 1
    assert done >= 3
    assert rows(out) == whole[: len(rows(out))]
    restart_case(out, comm, ["time.end=0.5"], "none")
    assert_whole(out, reference / "rigid", 27)


def test_a_hybrid_run_that_is_killed_can_go_on(demo, tmp_path, reference, comm):
    out, random = tmp_path / "out", np.random.default_rng(3)
    case = [demo("hybrid_soft.toml"), "-o", out, "--quiet", "--set", "time.end=1000", *HYBRID]
    for arguments in (("run", case), ("restart", [out, "--quiet"])):
        before = len(rows(out))
        with Run(*arguments) as run:
            more = before + int(random.integers(5, 12))
            run.wait_for(lambda more=more: len(rows(out)) > more)
            run.process.send_signal(signal.SIGKILL)
            run.process.wait()
    end = 0.02 * len(rows(out)) + 0.1
    restart_case(out, comm, [f"time.end={end:.2f}"], "none")
    assert rows(out) == rows(reference / "hybrid_soft")[: len(rows(out))]


@pytest.mark.parametrize("name", ["SIGINT", "SIGUSR1"])
def test_a_run_under_mpirun_that_is_interrupted_can_go_on(
    demo, tmp_path, reference, comm, launcher, name
):
    """mpirun hands SIGUSR1 on; after SIGINT it may kill the ranks before the step ends."""
    if launcher[0] is None:
        pytest.skip("there is no mpirun")
    out = tmp_path / "out"
    case = [demo("hybrid_soft.toml"), "-o", out, "--quiet", "--set", "time.end=1000", *HYBRID]
    with Run("run", case, 2, launcher) as run:
        run.wait_for(lambda: len(rows(out)) > 10)
        run.process.send_signal(signal.Signals[name])
        code, errors = run.finish()
    assert code != 0
    assert not any("Traceback" in line for line in errors), errors
    if name == "SIGUSR1":
        assert code == 130
        ours = [line for line in errors if line.startswith("error: ")]
        assert len(ours) == 1 and "interrupted at t = " in ours[0], errors
    end = 0.02 * len(rows(out)) + 0.1
    for _ in range(100):  # ranks that mpirun has left behind may hold the folder for a moment
        try:
            restart_case(out, comm, [f"time.end={end:.2f}"], "none")
            break
        except InputError as error:
            assert "in use" in str(error)
            time.sleep(0.1)
    found = read_history(out / "history.csv")
    whole = read_history(reference / "hybrid_soft" / "history.csv")
    n = min(len(run["time_[s]"]) for run in (found, whole))
    assert n > 12
    for column in ("time_[s]", "total_energy_[J]", "angle_rotor_[rad]", "tip_deflection_1_[m]"):
        expected = whole[column][:n]
        assert np.max(np.abs(found[column][:n] - expected)) <= 1e-9 * np.max(np.abs(expected)), (
            column
        )
