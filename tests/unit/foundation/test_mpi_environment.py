"""One rank alone starts without launcher and network, and nothing of that reaches others."""

import os
import subprocess
import sys

from mpi4py import MPI

import pytest

from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi, start_mpi_alone

OURS = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}
START = """
import os, subprocess
from turbine_fenicsx.cli.main import _start
comm = _start([], alone=False)
children = open(f"/proc/self/task/{os.getpid()}/children").read()
inherited = "OMPI_MCA_pml" in subprocess.run(["env"], capture_output=True, text=True).stdout
print(comm.size, bool(children.strip()), inherited)
"""


def set_environment(monkeypatch, **variables):
    """Nothing but these variables."""
    monkeypatch.setattr(os, "environ", variables)


def test_one_process_alone_needs_no_launcher(monkeypatch):
    set_environment(monkeypatch, HOME="/root")
    with start_mpi_alone():
        assert os.environ == {"HOME": "/root"} | OURS
    assert os.environ == {"HOME": "/root"}


@pytest.mark.parametrize(
    "name", ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID", "MPI_LOCALRANKID"]
)
def test_ranks_of_a_launcher_start_as_ever(monkeypatch, name):
    set_environment(monkeypatch, **{name: "0"})
    with start_mpi_alone():
        assert os.environ == {name: "0"}


def test_what_the_user_has_set_stays(monkeypatch):
    user = {"OMPI_MCA_pml": "ucx", "OMPI_MCA_btl": "self"}
    set_environment(monkeypatch, **user)
    with start_mpi_alone():
        assert os.environ["OMPI_MCA_pml"] == "ucx"
    assert os.environ == user


def test_children_that_need_no_mpi_do_not_hear_of_it(monkeypatch):
    set_environment(monkeypatch, PATH="/bin", OMPI_MCA_pml="ucx", PMI_RANK="1", MPI_LOCALRANKID="1")
    assert environment_without_mpi() == {"PATH": "/bin"}


@pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="starts a process of its own")
def test_the_command_line_starts_no_daemon_and_hands_nothing_on():
    package = {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", START]
    output = subprocess.run(
        command, env=environment_without_mpi() | package, capture_output=True, text=True, check=True
    ).stdout
    assert output.split() == ["1", "False", "False"]
