"""The first run compiles forms: it can be interrupted, and says what it needs."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SMALL = ("--quiet", "--set", "mesh.elements=[1,1,4]", "time.end=0.04")


@pytest.fixture
def environment(tmp_path):
    """Variables of a user who has compiled nothing yet, and whose compiler never ends."""
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\ntouch $XDG_CACHE_HOME/called\nexec sleep 60\n")
    compiler.chmod(0o755)
    return {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "CC": str(compiler)}


@pytest.mark.parametrize(("ranks", "number"), [(None, signal.SIGINT), (2, signal.SIGUSR1)])
def test_a_signal_ends_the_compilation(demo, tmp_path, environment, command_line, ranks, number):
    """Sent to the compiler as well, as a terminal does it; or by mpirun to all ranks."""
    arguments = ["run", demo("hybrid_stiff.toml"), "-o", tmp_path / "out", *SMALL]
    command = [sys.executable, "-m", "turbine_fenicsx", *map(str, arguments)]
    if ranks is not None:
        program, settings = command_line.__globals__["mpirun"]()
        if program is None:
            pytest.skip("there is no mpirun")
        command = [program, "-n", str(ranks), *command]
        environment = settings | environment
    run = subprocess.Popen(
        command, env=environment, cwd=ROOT, stderr=subprocess.PIPE, text=True, process_group=0
    )
    try:
        while not (tmp_path / "called").exists():
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.05)
        if ranks is None:
            os.killpg(run.pid, number)
        else:
            run.send_signal(number)
        _, err = run.communicate(timeout=30)
    finally:
        run.kill()
    errors = [line for line in err.splitlines() if line.startswith("error:")]
    assert errors == ["error: interrupted; what was written so far is complete"]
    assert "Traceback" not in err
    assert run.returncode == 130


@pytest.mark.parametrize("ranks", [None, 2])
def test_a_missing_compiler_is_one_sentence(
    demo, tmp_path, monkeypatch, environment, command_line, ranks
):
    monkeypatch.setenv("XDG_CACHE_HOME", environment["XDG_CACHE_HOME"])
    monkeypatch.setenv("CC", "/nowhere/gcc")
    run = command_line(
        "run", demo("hybrid_stiff.toml"), "-o", tmp_path / "out", *SMALL, ranks=ranks
    )
    assert run.returncode == 2
    assert "Traceback" not in run.stderr
    (error,) = (line for line in run.stderr.splitlines() if line.startswith("error:"))
    assert "FFCx needs a C compiler and there is no '/nowhere/gcc'" in error
