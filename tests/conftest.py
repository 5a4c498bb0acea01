"""What all tests share. Every rank runs every test, on ``MPI.COMM_WORLD``."""

import gc
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh
from progress import Progress, Watchdog

from turbine_fenicsx import NeoHooke, Revolute, StVenantKirchhoff
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about
from turbine_fenicsx.system.system import MultibodySystem

# tests/attack is imported by some; last, so that an installed package comes before the checkout's
sys.path.append(str(Path(__file__).parents[1]))


def pytest_addoption(parser):
    """``--progress``, as scripts/test.sh uses it."""
    text = "say how far the tests are, end those that hang; durations are kept in this folder"
    parser.addoption("--progress", type=Path, metavar="FOLDER", help=text)


@pytest.hookimpl(trylast=True)  # after the terminal
def pytest_configure(config):
    """See `progress`; the first rank speaks for all, and workers of pytest-xdist do not.

    Ctrl-C works as in a terminal, also where a script has started the tests in the background.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = config.getoption("progress")
    if folder:
        config.pluginmanager.register(Watchdog(config))
        if MPI.COMM_WORLD.rank == 0 and not hasattr(config, "workerinput"):
            terminal = config.pluginmanager.getplugin("terminalreporter")
            config.pluginmanager.register(Progress(folder, terminal))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes():
    """Start the workers with the environment as it was before MPI added to it: mpirun refuses to
    run under mpirun, and workers start it."""
    now = subprocess.run(["env", "-0"], capture_output=True, check=True).stdout
    for name in {os.fsdecode(line.partition(b"=")[0]) for line in now.split(b"\0")} - {""}:
        if name not in os.environ:
            os.unsetenv(name)


def pytest_collection_finish(session):
    """Leave collection of garbage to the fixture below, and spare it what the imports made."""
    gc.disable()
    gc.collect()
    gc.freeze()


def pytest_sessionfinish(session, exitstatus):
    """Where none of the chosen tests is for two ranks, that is no failure."""
    if MPI.COMM_WORLD.size > 1 and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.OK


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


class Machine:
    """A small turbine with one blade: nacelle, hub, both bearings, and a soft beam on the hub.

    The hub turns about e3 with ``spin`` [rad/s]; the beam points along e1. Its first natural
    period is some 0.5 s. All masses and stiffnesses count in ``unit`` [kg].
    """

    def __init__(self, comm, spin=0.0, cell="hexahedron", degree=1, law="svk", unit=1.0):
        self.comm = comm
        R = rotation_about(E1 + E2, 0.4)
        euler, w = unit * np.array([0.3, 0.4, 0.5]), spin * E3
        self.nacelle = RigidBody("nacelle", 2.0 * unit, euler, directors=R)
        euler = unit * np.array([0.2, 0.1, 0.05])
        self.hub = RigidBody("hub", unit, euler, position=-E3, directors=R.T, angular_velocity=w)
        self.yaw = Revolute("yaw", None, self.nacelle, point=(0.0, 0.1, 0.0), axis=-E2)
        self.rotor = Revolute("rotor", self.nacelle, self.hub, point=self.hub.position, axis=E3)
        corners = [[0.5, -0.25, -1.2], [1.5, 0.25, -0.8]]
        cells = mesh.create_box(comm, corners, [2, 1, 1], getattr(mesh.CellType, cell))
        laws = {"svk": StVenantKirchhoff, "neo_hooke": NeoHooke}
        material = laws[law](1200.0 * unit, 800.0 * unit)
        self.beam = FlexibleBody("beam", cells, material, 3.0 * unit, degree)
        self.root = Coupling("root", self.beam, self.facets(0.5), self.hub)

    def facets(self, x1):
        """Facets of the beam at a coordinate x1: 0.5 is its root and 1.5 its tip."""
        return mesh.locate_entities_boundary(self.beam.mesh, 2, lambda x: np.isclose(x[0], x1))

    @property
    def parts(self):
        return [self.nacelle, self.hub, self.yaw, self.rotor, self.beam, self.root]

    def system(self, *more, **options):
        return MultibodySystem(self.comm, [*self.parts, *more], **options)


@pytest.fixture(scope="session")
def machine(comm):
    """Makes a `Machine`, on all ranks unless told otherwise."""
    return lambda *args, comm=comm, **options: Machine(comm, *args, **options)
