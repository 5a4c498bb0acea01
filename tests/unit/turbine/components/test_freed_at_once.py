"""What holds distributed objects must go without the garbage collector: it comes at different times
on different ranks, and to free such objects is collective."""

import gc
import weakref

import pytest

from turbine_fenicsx.simulation.observers.history import History
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.run import make_stepper, turbine_channels
from turbine_fenicsx.turbine.run.summary import Statistics

pytestmark = pytest.mark.parallel

CASE = {
    "mesh": {"elements": [1, 1, 4]},
    "pitch": {"bearings": True},
    "blade": {"damping": "1 %"},
    "tower": {"flexible": True, "elements": [4, 1, 4], "damping": "1 %"},
}


def run(comm, folder):
    """Run a turbine for two steps; weak references to what it was made of."""
    turbine = build_turbine(Case.parse(CASE), comm)
    stepper = make_stepper(turbine.case, turbine.system)
    channels = turbine_channels(turbine, stepper, stress=True).history
    watching = [Statistics(), History(comm, folder / "history.csv", channels)]
    simulation = Simulation(turbine.system, 0.02, 0.04, watching, stepper)
    simulation.run()
    system = turbine.system
    things = (simulation, stepper, stepper.step, system, *system.flexible_models)
    return [weakref.ref(thing) for thing in (*things, *system.coupling_blocks)]


def test_a_run_leaves_no_circles_around_distributed_objects(comm, shared_tmp_path):
    assert not gc.isenabled()  # as in all tests
    run(comm, shared_tmp_path)  # the compiler of forms leaves circles of its own
    left = [type(thing()).__name__ for thing in run(comm, shared_tmp_path) if thing() is not None]
    assert left == []
