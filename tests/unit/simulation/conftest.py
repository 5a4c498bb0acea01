"""What the tests of checkpoints share."""

import numpy as np
import pytest

from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.simulation.checkpoint import save_state


@pytest.fixture
def system(machine):
    return machine(spin=3.0).system(Gravity())


@pytest.fixture
def example(system):
    """A state with a different number everywhere, as restart data."""
    state = system.initial_state()
    random = np.random.default_rng(5 + system.comm.rank)
    for vector in (*state.u, *state.v, *state.coupling):
        vector.array[:] = random.uniform(-1.0, 1.0, vector.getLocalSize())
    random = np.random.default_rng(4)
    for name in ("q", "q_dot", "joint_coordinates", "joint_rates", "multipliers"):
        values = getattr(state, name)
        values[:] = random.uniform(-1.0, 1.0, values.shape)
    state.time = 0.1 + 0.2  # not 0.3
    data = RestartData({"index": 7, "work": 1.0 / 3.0})
    data.add("state", save_state(system, state))
    return data
