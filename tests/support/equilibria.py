"""A body in a hinge, and how still a system in equilibrium stays, for tests of statics."""

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

A = RigidBody(
    "a", 2.0, (1, 2, 3), position=(3.0, 5.0, 2.0), directors=rotation_about((1, 0, 2), 0.7)
)
HINGE = Revolute("hinge", None, A, point=(4.0, 5.0, 2.0), axis=(0, 0, 1))


def residual_in_rest(system, state, dt=1e-3):
    """Largest change of velocity in a step from rest, over that of gravity."""
    solver, other = EnergyMomentum(system), state.copy()
    report = solver.advance(state, dt, other)
    solver.destroy()
    moved = [np.max(np.abs(other.q - state.q), initial=0.0)]
    moved += [(a - b).norm() for a, b in zip(other.u, state.u, strict=True)]
    return system.comm.allreduce(max(moved)) / (9.81 * dt**2), report
