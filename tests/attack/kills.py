"""Two-rank runs of the hybrid turbine, killed at any moment up to three times, then continued."""

import os
import signal
import subprocess
import sys
import time

from histories import read_lines

from tests.attack._runs import ROOT, SIZE, SOFT, command, differences
from tests.attack._tally import Tally
from tests.cli.conftest import mpirun

TRIES = 40
END = "time.end=0.4"


def attack(tries, random, folder):
    """Kill, go on, compare with the run that was never killed."""
    tally, whole = Tally(), folder / "whole"
    settings = ("--quiet", "--set", END)
    result = command("run", SOFT, "-o", whole, *settings, *SIZE, ranks=2)
    assert result.returncode == 0, result.stderr
    for k in range(tries):
        out = folder / str(k)
        for _ in range(int(random.integers(1, 4))):
            again = any((out / "checkpoints").glob("*.npz"))
            task = ("restart", out) if again else ("run", SOFT, "-o", out)
            more = () if again else SIZE
            before = len(read_lines(out)) if again else 0
            _kill(out, before + int(random.integers(0, 8)), random, *task, *settings, *more)
        result = command("restart", out, *settings, ranks=2)
        if result.returncode == 2 and "there is no checkpoint" in result.stderr:
            tally.hold("killed before the first checkpoint, and it says so")
        elif (
            result.returncode == 2
            and not (out / "case.json").exists()
            and "there is no run" in result.stderr
        ):
            tally.hold("killed before its folder held a run, and it says so")
        elif result.returncode:
            tally.break_(f"{out}: restart ended with {result.returncode}: {result.stderr[-300:]}")
        elif found := differences(out, whole):
            tally.break_(f"{out}: {', '.join(found)} is not that of the run that was not killed")
        else:
            tally.hold("went on bit for bit")
    return tally


def _kill(out, n_rows, random, *arguments):
    """Start the command on two ranks and kill all of it after some rows, or some time before."""
    program, settings = mpirun()
    process = subprocess.Popen(
        [program, "-n", "2", sys.executable, "-m", "turbine_fenicsx", *map(str, arguments)],
        env=settings | dict(os.environ),
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    history, start = out / "history.csv", time.monotonic()
    early = random.uniform(1.0, 6.0) if random.uniform() < 0.2 else 300.0
    while process.poll() is None and time.monotonic() - start < early:
        if history.exists() and len(history.read_text(errors="replace").splitlines()) > n_rows:
            break
        time.sleep(0.005)
    time.sleep(random.uniform(0.0, 0.05))
    # the ranks are in groups of their own, which the session joins
    session = process.pid
    for line in subprocess.run(
        ["ps", "-o", "pid=", "-s", str(session)], capture_output=True, text=True
    ).stdout.split():
        try:
            os.kill(int(line), signal.SIGKILL)
        except ProcessLookupError:
            continue
    process.wait()
