"""scripts/test.sh: what ends it, and what it says then."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from patience import patience

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]

FAILS = """
def test_fails():
    open("failed", "w").close()
    assert 'a mistake' == ''
"""
HANGS = """
import os, subprocess, time
import pytest
from mpi4py import MPI

@pytest.mark.parallel
def test_hangs():
    if MPI.COMM_WORLD.size == RANKS:
        child = subprocess.Popen(["sleep", "1000"])
        print(os.getpid(), child.pid, file=open(f"pids_{MPI.COMM_WORLD.rank}", "w"))
        os.rename(f"pids_{MPI.COMM_WORLD.rank}", f"running_{MPI.COMM_WORLD.rank}")
        time.sleep(1000)
"""


@pytest.fixture
def start(tmp_path, command_line):
    """Start a copy of the script on one test that fails and one that hangs on so many ranks."""
    launcher, settings = command_line.__globals__["mpirun"]()
    if launcher is None:
        pytest.skip("there is no mpirun")
    started = []

    def run(ranks, *arguments, hang=300.0):
        for name in (
            "pyproject.toml",
            "scripts/test.sh",
            "tests/conftest.py",
            "tests/support/patience.py",
        ):
            (tmp_path / name).parent.mkdir(exist_ok=True)
            shutil.copy(ROOT / name, tmp_path / name)
        progress = (ROOT / "tests" / "progress.py").read_text()
        assert "HANG = 300.0" in progress
        (tmp_path / "tests" / "progress.py").write_text(progress.replace("300.0", str(hang), 1))
        hangs = HANGS.replace("RANKS", str(ranks))
        (tmp_path / "tests" / "test_one.py").write_text((FAILS if ranks == 1 else "") + hangs)
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        process = subprocess.Popen(
            ["bash", str(tmp_path / "scripts" / "test.sh"), *arguments],
            env=settings | dict(os.environ) | {"PATH": path, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,  # as in a terminal of its own
        )
        started.append(process)
        return process

    yield run
    for process in started:
        process.terminate()
        process.communicate(timeout=patience(15.0))


def is_running(pid):
    """Whether there is such a process that has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("ranks", [1, 2])
def test_ctrl_c_ends_the_script_and_all_it_has_started(start, tmp_path, ranks):
    process, begin = start(ranks), time.monotonic()
    files = [tmp_path / f"running_{rank}" for rank in range(ranks)]
    while not all(file.exists() for file in files):
        assert process.poll() is None, process.stdout.read()
        assert time.monotonic() - begin < patience(100.0)
        time.sleep(0.1)
    while ranks == 1 and not (tmp_path / "failed").exists():
        assert time.monotonic() - begin < patience(100.0)
        time.sleep(0.1)
    time.sleep(patience(1.0))  # until its failure has been told
    pids = [int(pid) for file in files for pid in file.read_text().split()]
    assert all(map(is_running, pids))
    os.killpg(process.pid, signal.SIGINT)  # what a terminal does
    text, _ = process.communicate(timeout=patience(15.0))
    assert process.returncode == 130
    assert text.endswith("== stopped by SIGINT\n")
    assert ("FAILED tests/test_one.py::test_fails" in text) == (ranks == 1)
    begin = time.monotonic()
    while any(map(is_running, pids)):
        assert time.monotonic() - begin < patience(5.0)
        time.sleep(0.1)


def test_a_test_that_hangs_fails_alone(start):
    """Its worker is ended, with the stack; the other tests are told as usual."""
    text, _ = start(1, "-n", "1", "tests", hang=3.0).communicate(timeout=patience(150.0))
    assert "in test_hangs" in text
    assert "crashed while running 'tests/test_one.py::test_hangs'" in text
    assert "assert 'a mistake' == ''" in text and "= 2 failed in " in text


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_hang_without_workers_ends_the_script_with_what_had_failed(start, ranks):
    process = start(ranks, "-n", "0", "tests", hang=3.0)
    text, _ = process.communicate(timeout=patience(150.0))
    assert process.returncode not in (0, 130)
    assert "in test_hangs" in text and f"pytest was ended on {ranks} rank(s)" in text
    assert ("until then: 1\n" in text and "assert 'a mistake' == ''" in text) == (ranks == 1)


def test_the_subset_for_other_releases_names_files_that_are_there():
    script = ROOT / "scripts" / "test_subset.sh"
    result = subprocess.run(["bash", script, "--list"], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    files = result.stdout.split()
    assert len(files) > 20
    assert [name for name in files if not (ROOT / name).exists()] == []
