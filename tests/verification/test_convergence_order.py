"""The step is of second order in dt: angles, displacements, velocities and multipliers."""

import numpy as np
import pytest
from beams import beam
from runs import comm

from turbine_fenicsx import (
    Coupling,
    EnergyMomentum,
    JointTorque,
    MultibodySystem,
    NeoHooke,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)

END = 0.3
YOUNG = 2e5  # the first natural period of the beam, 0.3 s, is 30 of the largest steps
LAWS = {
    "st_venant_kirchhoff": StVenantKirchhoff(0.8 * YOUNG, 0.4 * YOUNG),
    "neo_hooke": NeoHooke(0.8 * YOUNG, 0.4 * YOUNG),
}


def smoothly_driven(law):
    """A spinning hub with a beam on a fixed bearing, under a torque without any kink."""
    hub = RigidBody("hub", 300.0, (30.0, 40.0, 50.0), angular_velocity=(0.0, 0.0, 0.5))
    body, root = beam(LAWS[law], "hexahedron", 1)
    spin = Revolute("spin", None, hub, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    torque = JointTorque(
        "torque on spin", "spin", 1.0, lambda t: 6000.0 * np.sin(np.pi * t / 0.4) ** 4
    )
    return MultibodySystem(comm, [hub, body, Coupling("root", body, root, hub), spin, torque])


def state_at_end(system, dt):
    """Everything at `END`; multipliers as means of the steps before and after it."""
    solver = EnergyMomentum(system)
    state, other = system.initial_state(), system.initial_state()
    for _ in range(round(END / dt)):
        solver.advance(state, dt, other)
        state, other = other, state
    solver.advance(state, dt, other)
    found = {
        "angle": state.joint_coordinates.copy(),
        "rigid coordinates": state.q.copy(),
        "rigid velocities": state.q_dot.copy(),
        "joint multipliers": 0.5 * (state.multipliers + other.multipliers),
        "late multipliers": state.multipliers.copy(),
        "displacement": state.u[0].array.copy(),
        "velocity": state.v[0].array.copy(),
        "coupling forces": 0.5 * (state.coupling[0].array + other.coupling[0].array),
    }
    solver.destroy()
    return found


def distance(a, b, name):
    """Norm of a difference; fields are distributed."""
    square = float(np.sum((a[name] - b[name]) ** 2))
    if name in ("displacement", "velocity", "coupling forces"):
        square = comm.allreduce(square)
    return np.sqrt(square)


@pytest.fixture(scope="module", params=LAWS)
def orders(request):
    """Order of each quantity from the differences between dt, dt/2 and dt/4."""
    system = smoothly_driven(request.param)
    coarse, middle, fine = (state_at_end(system, dt) for dt in (0.01, 0.005, 0.0025))
    return {
        name: np.log2(distance(coarse, middle, name) / distance(middle, fine, name))
        for name in coarse
    }


# Measured: 1.93 to 2.00, and nearer to 2 for smaller steps; a scheme of first or third order is
# four times farther off.
@pytest.mark.parametrize(
    "name",
    [
        "angle",
        "rigid coordinates",
        "rigid velocities",
        "joint multipliers",
        "displacement",
        "velocity",
        "coupling forces",
    ],
)
def test_quantity_converges_with_second_order(orders, name):
    assert orders[name] == pytest.approx(2.0, abs=0.2)


def test_multipliers_belong_to_the_middle_of_the_step(orders):
    # taken for those of its end they are half a step late, an error of first order
    assert orders["late multipliers"] == pytest.approx(1.0, abs=0.2)
