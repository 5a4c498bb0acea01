"""Claims about steady rotation, and about what changes as a system turns."""

import logging

import numpy as np
import pytest

from turbine_fenicsx import (
    Constant,
    Gravity,
    JointDamper,
    JointSpring,
    JointTorque,
    PointForce,
    PrescribedMotion,
    Prismatic,
    Revolute,
)
from turbine_fenicsx.analysis import turning
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_blocks import TurningBlocks
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

EULER = (0.2, 0.1, 0.05)
HUB = RigidBody("hub", 1.0, EULER)
ROTOR = Revolute("rotor", None, HUB, point=(0, 0, 0), axis=E3)


def advance(system, state, dt, steps, watch=lambda state: None, **options):
    """Largest number of iterations of some steps, and the state after them."""
    solver = EnergyMomentum(system, options=SolverOptions(**options))
    now, after, most = state.copy(), state.copy(), 0
    for _ in range(steps):
        report = solver.advance(now, dt, after)
        most, now, after = max(most, report.newton_iterations), after, now
        watch(now)
    solver.destroy()
    return most, now


def rotor_on_ground(m, *more):
    """The small turbine without nacelle."""
    rotor = Revolute("rotor", None, m.hub, point=m.hub.position, axis=E3)
    return MultibodySystem(m.comm, [m.hub, rotor, m.beam, m.root, *more])


def from_hub(system, state):
    """Positions of the owned nodes of the blade in the axes of the hub."""
    x = system.flexible_models[0].positions + state.u[0].array_r.reshape(-1, 3)
    return (x - state.q[:3]) @ state.q[3:12].reshape(3, 3).T


# --- steady rotation


def governor(comm, speed, length=0.5, more=()):
    """A ball on a massless arm from the axis, which gravity pulls along the axis."""
    hub = RigidBody("hub", 1.0, EULER)
    ball = RigidBody("ball", 2.0, (1e-9, 1e-9, 1e-9), position=length * E1)
    parts = [hub, ball, Revolute("rotor", None, hub, point=(0, 0, 0), axis=E3)]
    parts += [Revolute("arm", hub, ball, point=(0, 0, 0), axis=E2), Gravity((0, 0, -9.81)), *more]
    system = MultibodySystem(comm, parts)
    return system, turning_equilibrium(system, "rotor", speed)


@pytest.mark.parametrize("speed", [6.0, -9.0, 20.0])
def test_a_governor_rises_as_it_turns(comm, speed):
    """A conical pendulum: the angle from the vertical has the cosine g/(Omega^2 l)."""
    system, state = governor(comm, speed)
    down = -state.q[14] / 0.5
    assert down == pytest.approx(9.81 / (speed**2 * 0.5), rel=1e-8)  # the ball is no point
    assert state.joint_rates.tolist() == [speed, 0.0]
    assert system.constraint_error(state) <= 1e-13
    # it stays so, for steps that are not small: 0.3 rad
    radius = []
    most, after = advance(system, state, 0.3 / abs(speed), 50, lambda s: radius.append(s.q[14]))
    assert np.ptp(radius) <= 1e-11 and most <= 3
    assert system.balance(after).total == pytest.approx(system.balance(state).total, rel=1e-12)
    assert after.joint_rates[0] == pytest.approx(2 * np.arctan(0.15) / 0.3 * speed, rel=1e-12)


@pytest.mark.parallel
@pytest.mark.parametrize(("law", "degree"), [("svk", 1), ("neo_hooke", 2)])
def test_a_blade_stays_still_in_the_turning_frame(comm, machine, law, degree):
    system = rotor_on_ground(machine(law=law, degree=degree))
    speed, dt = 3.0, 0.02
    state = turning_equilibrium(system, "rotor", speed)
    assert state.u[0].norm(3) > 1e-3
    shape, gaps = from_hub(system, state), []

    def watch(now):
        gaps.append(np.max(np.abs(from_hub(system, now) - shape), initial=0.0))

    turns = int(np.ceil(10 * 2 * np.pi / (speed * dt)))
    most, after = advance(system, state, dt, turns, watch)
    assert comm.allreduce(max(gaps), op=max) <= 1e-9  # of the blade, which is 1 m long
    assert system.balance(after).total == pytest.approx(system.balance(state).total, rel=1e-9)
    assert most <= 2


@pytest.mark.parallel
def test_the_multipliers_are_those_of_the_first_step(comm, machine):
    """Forces in the middle of a step are those at its start, turned by half its angle."""
    system = rotor_on_ground(machine())
    state = turning_equilibrium(system, "rotor", 3.0)
    dt = 1e-3
    _, after = advance(system, state, dt, 1)
    half = rotation_about(E3, 0.5 * 3.0 * dt)
    held = state.coupling[0].array_r.reshape(-1, 3) @ half.T
    size = state.coupling[0].norm()
    assert size > 1.0
    assert np.allclose(after.coupling[0].array_r.reshape(-1, 3), held, rtol=0, atol=1e-5 * size)
    assert np.allclose(after.multipliers, state.multipliers, rtol=0, atol=1e-2)


def test_a_start_at_another_angle_keeps_it(comm, machine):
    system = rotor_on_ground(machine())
    first = turning_equilibrium(system, "rotor", 3.0)
    turned = system.initial_state()
    turning.turning_frame(system, "rotor", 3.0).turn(turned, 0.8)
    second = turning_equilibrium(system, "rotor", 3.0, turned)
    assert second.joint_coordinates.tolist() == [0.8]
    assert np.allclose(from_hub(system, first), from_hub(system, second), rtol=0, atol=1e-12)


def test_a_stiff_governor_balances_weight_centrifugal_force_and_spring(comm):
    _, state = governor(comm, 40.0, more=[JointSpring("s", "arm", 5.0)])
    angle = state.joint_coordinates[1]
    moment = 2.0 * 9.81 * 0.5 * np.cos(angle) - 2.0 * 1600.0 * 0.25 * np.sin(angle) * np.cos(angle)
    assert 5.0 * angle == pytest.approx(moment, abs=1e-6)


def blade_on_carriage(m):
    """The blade alone is no balanced rotor: it drags the axis with it."""
    carriage = RigidBody("carriage", 1.0, EULER, position=m.hub.position)
    slide = Prismatic("slide", None, carriage, point=m.hub.position, axis=E1)
    rotor = Revolute("rotor", carriage, m.hub, point=m.hub.position, axis=E3)
    parts = [m.hub, carriage, slide, JointSpring("k", "slide", 100.0), rotor, m.beam, m.root]
    return MultibodySystem(m.comm, parts)


@pytest.mark.parametrize("make", [rotor_on_ground, blade_on_carriage])
def test_newton_converges_quadratically_and_high_speeds_are_reached_in_steps(
    machine, make, monkeypatch
):
    """12 rad/s stretch the blade by 10 %, 20 rad/s by 25 %."""
    system = make(machine())
    few = {"periodic": True, "max_iterations": 5}
    at_once = turning_equilibrium(system, "rotor", 20.0, periodic=True)
    in_steps = turning_equilibrium(system, "rotor", 20.0, **few)
    assert (at_once.u[0] - in_steps.u[0]).norm() <= 1e-10 * at_once.u[0].norm()
    monkeypatch.setattr(turning, "SPEED_STEPS", (1,))
    turning_equilibrium(system, "rotor", 12.0, **few)
    with pytest.raises(StepFailure):
        turning_equilibrium(system, "rotor", 20.0, **few)


def turntable(comm, speed, offset=0.0, more=(), **options):
    """A disc on a carriage on a spring, all in the plane of the disc; the force is 10 N."""
    carriage = RigidBody("carriage", 1.0, EULER)
    disc = RigidBody("disc", 2.0, (0.1, 0.1, 0.1), position=offset * E1)
    parts = [carriage, disc, Prismatic("slide", None, carriage, point=(0, 0, 0), axis=E1)]
    parts += [
        Revolute("rotor", carriage, disc, point=(0, 0, 0), axis=E3),
        JointSpring("k", "slide", 100.0),
    ]
    parts += [
        PointForce("push", carriage, point=(0, 0, 0), force=10.0 * E1, function=Constant(1.0)),
        *more,
    ]
    system = MultibodySystem(comm, parts)
    return system, turning_equilibrium(system, "rotor", speed, **options)


@pytest.mark.parametrize("speed", [1.0, 5.0, 7.0, 30.0])
def test_the_axis_moves_with_what_carries_it(comm, speed):
    """Below and above the speed of 7.07 rad/s at which centrifugal forces outgrow the spring."""
    system, state = turntable(comm, speed)
    assert state.joint_coordinates.tolist() == pytest.approx([0.1, 0.0], abs=1e-12)
    assert state.q[12] == pytest.approx(0.1, abs=1e-12)
    assert np.max(np.abs(state.q_dot[:15])) <= 1e-12
    _, after = advance(system, state, 0.1 / speed, 20)
    assert after.joint_coordinates[0] == pytest.approx(0.1, abs=1e-11)


def test_the_axis_tilts_with_what_carries_it(comm):
    """A governor on a pendulum that a spring and a couple hold inclined, gravity off."""
    frame = RigidBody("frame", 1.0, EULER)
    parts = [frame, HUB, Revolute("tilt", None, frame, point=(0, 0, 0), axis=E2)]
    parts += [
        Revolute("rotor", frame, HUB, point=(0, 0, 0), axis=E3),
        JointSpring("k", "tilt", 100.0),
    ]
    system = MultibodySystem(comm, [*parts, JointTorque("t", "tilt", 30.0, Constant(1.0))])
    state = turning_equilibrium(system, "rotor", 12.0)
    assert state.joint_coordinates.tolist() == pytest.approx([0.3, 0.0], abs=1e-12)
    axis = rotation_about(E2, 0.3) @ E3
    expected = np.cross(12.0 * axis, state.q[15:24].reshape(3, 3)).ravel()
    assert np.allclose(state.q_dot[15:24], expected, rtol=0, atol=1e-12)


# --- what is not steady


def test_an_unbalanced_rotor_on_a_soft_support_is_refused_or_periodic(comm):
    offset, speed = 0.01, 2.0
    with pytest.raises(ModelError, match=r"not steady: the shape changes by .* of the size"):
        turntable(comm, speed, offset)
    system, state = turntable(comm, speed, offset, periodic=True)
    # quasi-static: k x = F + m e Omega^2 cos(angle)
    assert state.joint_coordinates[0] == pytest.approx(0.1 + 2 * offset * 0.04, rel=1e-9)
    assert state.joint_rates[0] == pytest.approx(0.0, abs=1e-9)
    turned = state.copy()
    turning.turning_frame(system, "rotor", speed, state).turn(turned, 0.5 * np.pi)
    state = turning_equilibrium(system, "rotor", speed, turned, periodic=True)
    assert state.joint_coordinates[0] == pytest.approx(0.1, rel=1e-9)
    assert state.joint_rates[0] == pytest.approx(-2 * offset * 0.04 * speed, rel=1e-5)
    # one velocity for all: the disc's centre turns about an axis that moves
    assert state.q_dot[0] == pytest.approx(state.joint_rates[0], rel=1e-9)
    assert state.q_dot[12] == pytest.approx(state.joint_rates[0] - speed * offset, rel=1e-6)
    J = system.rigid_model.constraint_jacobian(state.q, state.joint_coordinates)
    rates = np.concatenate([state.q_dot, state.joint_rates])
    assert np.max(np.abs(J @ rates)) <= 1e-8


def test_gravity_across_the_axis_is_refused_or_periodic(comm, machine):
    system = rotor_on_ground(machine(), Gravity((0, -1.0, 0)))
    with pytest.raises(ModelError, match=r"a torque of .* N m about its axis changes the speed"):
        turning_equilibrium(system, "rotor", 1.0)
    state = turning_equilibrium(system, "rotor", 1.0, periodic=True)
    # the blade points along e1 and bends down; its velocity is that of shapes before and after
    shapes = []
    for angle in (-0.02, 0.02):
        turned = state.copy()
        turning.turning_frame(system, "rotor", 1.0, state).turn(turned, angle)
        shapes.append(
            from_hub(system, turning_equilibrium(system, "rotor", 1.0, turned, periodic=True))
        )
    still = turning_equilibrium(system, "rotor", 1.0, periodic=True)
    turning.turning_frame(system, "rotor", 1.0, state).set_velocities(still)
    change, D = (state.v[0] - still.v[0]).array_r, state.q[3:12].reshape(3, 3)
    assert np.allclose(change, (25.0 * (shapes[1] - shapes[0]) @ D).ravel(), rtol=0, atol=1e-7)
    assert comm.allreduce(np.max(np.abs(change), initial=0.0), op=max) > 5e-4


def test_a_torque_about_the_axis_is_refused_unless_a_damper_balances_it(comm, caplog):
    torque, damper = JointTorque("t", "rotor", 6.0, Constant(1.0)), JointDamper("d", "rotor", 2.0)
    for more, sum_of_torques in (([torque], "6"), ([damper], "-6")):
        with pytest.raises(ModelError, match=f"a torque of {sum_of_torques} N m"):
            turning_equilibrium(MultibodySystem(comm, [HUB, ROTOR, *more]), "rotor", 3.0)
    system = MultibodySystem(comm, [HUB, ROTOR, torque, damper])
    state = turning_equilibrium(system, "rotor", 3.0)
    _, after = advance(system, state, 0.01, 100)
    assert after.joint_rates[0] == pytest.approx(3.0, rel=1e-3)
    system = MultibodySystem(comm, [HUB, ROTOR, torque])
    with caplog.at_level(logging.INFO):
        turning_equilibrium(system, "rotor", 3.0, periodic=True)
    assert "a torque of 6 N m changes the speed by 20 rad/s^2" in caplog.text or comm.rank


def test_a_driven_rotor_turns_as_its_motion_says(comm, machine):
    m = machine()
    system = rotor_on_ground(m, PrescribedMotion("rotor", lambda t: 3.0 * t))
    state = turning_equilibrium(system, "rotor", 3.0)
    free = turning_equilibrium(rotor_on_ground(m), "rotor", 3.0)
    assert (state.u[0] - free.u[0]).norm() <= 1e-12
    with pytest.raises(ModelError, match="not steady"):
        turning_equilibrium(system, "rotor", 2.0)


def test_speed_zero_holds_the_joint(comm, machine):
    """Under the weight a pendulum would fall; held, it is in equilibrium."""
    system = MultibodySystem(comm, [HUB, ROTOR, JointTorque("t", "rotor", 6.0, Constant(1.0))])
    state = turning_equilibrium(system, "rotor", 0.0)
    assert not state.q_dot.any() and np.array_equal(state.q, HUB.coordinates)


def test_other_coordinates_can_be_held(comm, machine):
    m = machine()
    system = m.system()
    state = turning_equilibrium(system, "rotor", 3.0, periodic=True, held=["yaw"])
    assert state.joint_coordinates.tolist() == [0.0, 0.0]
    with pytest.raises(
        ModelError, match=r"no joint coordinate 'jaw'; there are \['rotor', 'yaw'\]"
    ):
        turning_equilibrium(system, "rotor", 3.0, held=["jaw"])


@pytest.mark.parallel
def test_no_equilibrium_is_told(comm):
    system = MultibodySystem(comm, [HUB, ROTOR])
    with pytest.raises(StepFailure, match="no equilibrium at t = 0 s"):
        turning_equilibrium(system, "rotor", 3.0, max_iterations=0)


def test_an_iteration_that_goes_astray_is_a_failure_and_no_mistake_of_the_joint(comm):
    system = MultibodySystem(comm, [HUB, ROTOR])
    state = system.initial_state()
    blocks = TurningBlocks(turning_frame(system, "rotor", 3.0), state, [0])
    state.q[3:12] *= [1e5, 3e4, -2e4] * 3
    with pytest.raises(StepFailure, match="was not found: joint 'rotor' has no angle"):
        blocks.residual()
    blocks.destroy()
    state.destroy()
