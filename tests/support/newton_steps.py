"""Steps of a small machine with any linear solver, for tests of Newton's method."""

import numpy as np
import pytest

from turbine_fenicsx import Gravity, Hat, JointTorque, Revolute
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E3
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

DT = 0.02
PREFIX = "test_newton_"
all_solvers = pytest.mark.parametrize("name", sorted(LINEAR_SOLVERS))


def options(name="lu", **changes):
    return SolverOptions(linear_solver=name, prefix=PREFIX, **changes)


def loaded(m):
    return m.system(Gravity(), JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0)))


def values(state):
    arrays = (state.q, state.q_dot, state.joint_coordinates, state.joint_rates, state.multipliers)
    fields = (x.array_r for f in (state.u, state.v, state.coupling) for x in f)
    return [np.array([state.time]), *(np.copy(a) for a in (*arrays, *fields))]


def equal(a, b):
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def run(solver, system, steps=3, dt=DT):
    """State after some steps from the start, and the reports."""
    state, out, reports = system.initial_state(), system.initial_state(), []
    for _ in range(steps):
        reports.append(solver.advance(state, dt, out))
        state, out = out, state
    return state, reports


def spinning_top(comm, spin):
    top = RigidBody("top", 1.0, (1.0, 1.0, 1.0), angular_velocity=spin * E3)
    return MultibodySystem(comm, [top, Revolute("axis", None, top, point=(0, 0, 0), axis=E3)])
