"""How the tests of the command line start it: as a user would, in processes of its own."""

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

from mpi4py import MPI

import pytest
from patience import patience
from users_meshes import write_meshes

ROOT = Path(__file__).parents[2]
WAITED = re.compile(r"^.*waiting for another process to compile .*\n", re.MULTILINE)


def pytest_runtest_setup(item):
    """These tests start MPI themselves, so one rank of them is enough."""
    if MPI.COMM_WORLD.size > 1:
        pytest.skip("starts processes, with and without mpirun, from one rank")


@cache
def mpirun():
    """The mpirun that belongs to this python, and variables that let it have more ranks than cores.

    Variables of the environment, such as those of scripts/test.sh, have precedence.
    """
    folders = [Path(python).parent for python in (sys.executable, sys._base_executable)]
    beside = [str(f / "mpirun") for f in folders if (f / "mpirun").exists()]
    program = beside[0] if beside else shutil.which("mpirun")
    if program is None:
        return None, {}
    settings = {
        "OMP_NUM_THREADS": "1",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "OMPI_MCA_hwloc_base_binding_policy": "none",
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    }
    version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
    if "Open MPI) 5." in version:
        settings["PRTE_MCA_rmaps_default_mapping_policy"] = ":oversubscribe"
    elif "Open MPI" in version:
        settings["PRTE_MCA_mapby"] = ":oversubscribe"
    return program, settings


def run_command(*arguments, ranks=None, timeout=120.0, program=None):
    """Run the command line and return the finished process, with its output as text.

    That it has waited for another test to compile forms is left out.

    Args:
        arguments: Arguments of the command line.
        ranks: Number of MPI ranks; None runs it without mpirun.
        timeout: Seconds after which the test fails, as when ranks wait for each other; more on a
            busy machine [s].
        program: What to run instead of ``python -m turbine_fenicsx``.
    """
    command = [*(program or [sys.executable, "-m", "turbine_fenicsx"]), *map(str, arguments)]
    environment = dict(os.environ)  # as it was when this process began, before MPI added to it
    if ranks is not None:
        launcher, settings = mpirun()
        if launcher is None:
            pytest.skip("there is no mpirun")
        command = [launcher, "-n", str(ranks), *command]
        environment = settings | environment
    result = subprocess.run(
        command,
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=patience(timeout),
    )
    result.stderr = WAITED.sub("", result.stderr)
    return result


@pytest.fixture(scope="session")
def command_line():
    """Runs the command line, see `run_command`."""
    return run_command


@pytest.fixture(scope="session")
def demo():
    """Path of one of the paper's cases by name."""
    return lambda name: ROOT / "demos" / "paper" / name


@pytest.fixture(scope="session")
def meshes(tmp_path_factory):
    """Folder of `users_meshes`."""
    folder = tmp_path_factory.mktemp("meshes")
    write_meshes(folder)
    return folder


@pytest.fixture
def no_pictures(monkeypatch):
    """They take longer than the runs."""
    monkeypatch.setattr("turbine_fenicsx.cli.commands._running._draw_history", lambda *_: [])
