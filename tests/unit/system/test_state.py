"""Claims about the state of a system."""

import numpy as np
import pytest

from turbine_fenicsx.system.state import State

pytestmark = pytest.mark.parallel

ARRAYS = ("q", "q_dot", "joint_coordinates", "joint_rates", "multipliers")
FIELDS = ("u", "v", "coupling")


def numbered(state):
    """Give every entry of a state a value that tells the entries apart."""
    for k, name in enumerate(ARRAYS, start=1):
        getattr(state, name)[:] = k
    for k, name in enumerate(FIELDS, start=len(ARRAYS) + 1):
        for vector in getattr(state, name):
            vector.set(float(k))
    state.time = 0.5
    return state


def values(state):
    arrays = [getattr(state, name) for name in ARRAYS]
    return [np.copy(a) for a in (*arrays, *(x.array_r for f in FIELDS for x in getattr(state, f)))]


def test_a_copy_has_the_same_values_in_the_same_places(machine):
    state = numbered(machine().system().initial_state())
    twin = state.copy()
    assert isinstance(twin, State) and twin.time == 0.5
    assert all(np.array_equal(a, b) for a, b in zip(values(state), values(twin), strict=True))
    assert all(np.all(a == k) for k, a in enumerate(values(twin), start=1))


def test_a_copy_is_independent(machine):
    state = numbered(machine().system().initial_state())
    before, twin = values(state), state.copy()
    for name in ARRAYS:
        getattr(twin, name)[:] = -1.0
    for name in FIELDS:
        for vector in getattr(twin, name):
            vector.set(-1.0)
    twin.time = 9.0
    assert state.time == 0.5
    assert all(np.array_equal(a, b) for a, b in zip(before, values(state), strict=True))
    twin.destroy()
    assert all(np.array_equal(a, b) for a, b in zip(before, values(state), strict=True))


def test_initial_states_are_independent_of_each_other(machine):
    system = machine().system()
    one, other = system.initial_state(), system.initial_state()
    numbered(one)
    assert all(np.all(a == 0.0) for a in values(other)[2:])  # all but q and its rates
    assert not np.array_equal(one.q, other.q)
