"""What all tests share. Every rank runs every test, on ``MPI.COMM_WORLD``."""

import gc
import shutil
import tempfile
from pathlib import Path

from mpi4py import MPI

import pytest


def pytest_collection_finish(session):
    """Leave collection of garbage to the fixture below, and spare it what the imports made."""
    gc.disable()
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def in_step():
    """After each test destroy what it left behind, on all ranks at once: destructors of
    distributed PETSc objects are collective."""
    yield
    gc.collect()
    MPI.COMM_WORLD.barrier()


@pytest.fixture(scope="session")
def comm():
    """The communicator of all ranks."""
    return MPI.COMM_WORLD


@pytest.fixture
def shared_tmp_path(comm):
    """An empty directory, the same on every rank."""
    path = comm.bcast(Path(tempfile.mkdtemp()) if comm.rank == 0 else None)
    yield path
    comm.barrier()
    if comm.rank == 0:
        shutil.rmtree(path)
