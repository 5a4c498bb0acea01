"""Claims about static equilibrium of rigid bodies, and about what has none."""

import logging
import re

import numpy as np
import pytest
from equilibria import HINGE, A, residual_in_rest

from turbine_fenicsx import (
    Cylindrical,
    FollowerForce,
    Gravity,
    JointDamper,
    JointSpring,
    JointTorque,
    PointForce,
    PointSpring,
    PrescribedMotion,
    Revolute,
    Spherical,
)
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

N = np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0])


def test_a_hanging_body_turns_until_spring_and_weight_balance(comm):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    state = equilibrium(system)
    T = state.joint_coordinates[0]
    # the arm of 1 m points to -e1 initially and comes down as the angle grows
    assert 100.0 * T == pytest.approx(2.0 * 9.81 * np.cos(T), rel=1e-12)
    assert np.all(state.q_dot == 0.0) and state.time == 0.0
    assert system.constraint_error(state) <= 1e-13
    assert residual_in_rest(system, state)[0] <= 1e-9


def test_a_system_in_equilibrium_stays_where_it_is(comm):
    """Whether or not anything but joint forces holds it: the multipliers come first."""
    for point, more in (
        ((3.0, 6.0, 2.0), [Gravity()]),  # hangs
        ((3.0, 4.0, 2.0), [Gravity()]),  # stands, unstable
        ((4.0, 5.0, 2.0), [JointSpring("s", "hinge", 10.0)]),
        ((4.0, 5.0, 2.0), []),
    ):
        hinge = Revolute("hinge", None, A, point=point, axis=(0, 0, 1))
        state = equilibrium(MultibodySystem(comm, [A, hinge, *more]))
        assert np.allclose(state.q, A.coordinates, rtol=0, atol=1e-13)


def chain(n, more=()):
    """Links of 1 m that hang on each other at an angle, with springs in hinges about e3."""
    parts, last, at = [], None, np.zeros(3)
    for k in range(n):
        way = np.array([np.sin(0.5), -np.cos(0.5), 0.0])
        link = RigidBody(f"link {k}", 1.0 + k, (0.1, 0.2, 0.1), position=at + 0.5 * way)
        parts += [link, Revolute(f"j{k}", last, link, point=at, axis=(0, 0, 1))]
        parts += [JointSpring(f"s{k}", f"j{k}", 6.0), *(m(k) for m in more)]
        last, at = link, at + way
    return [*parts, Gravity()]


def test_a_hanging_chain_with_springs_is_where_a_damped_motion_comes_to_rest(comm):
    state = equilibrium(MultibodySystem(comm, chain(4)))
    damped = MultibodySystem(
        comm, chain(4, [lambda k: JointDamper(f"d{k}", f"j{k}", 100.0 / (k + 1) ** 2)])
    )
    solver = EnergyMomentum(damped)
    at = damped.initial_state()
    other = at.copy()
    for _ in range(300):
        solver.advance(at, 0.2, other)
        at, other = other, at
    solver.destroy()
    assert np.max(np.abs(state.joint_coordinates)) > 0.2
    assert np.allclose(state.joint_coordinates, at.joint_coordinates, rtol=0, atol=1e-6)
    assert np.allclose(state.q, at.q, rtol=0, atol=1e-6)
    # multipliers are the joint forces; those of the motion alternate about them
    mean = 0.5 * (at.multipliers + other.multipliers)
    assert np.allclose(state.multipliers, mean, rtol=0, atol=1e-4)
    assert equilibrium(damped).joint_coordinates == pytest.approx(
        state.joint_coordinates, abs=1e-12
    )  # without dampers


def test_joint_coordinates_can_be_held(comm):
    system = MultibodySystem(comm, chain(4))
    state = equilibrium(system, held=["j0", "j2"])
    T = state.joint_coordinates
    assert T[0] == T[2] == 0.0 and np.min(np.abs(T[[1, 3]])) > 0.01
    driven = [PrescribedMotion("j1", lambda t: 0.3 * t)]
    state = equilibrium(MultibodySystem(comm, [*chain(4), *driven]), [1.0], held=["j1"])
    assert state.joint_coordinates[1] == pytest.approx(0.3)
    with pytest.raises(ModelError, match=r"no joint coordinate 'j7'; there are \['j0', 'j1'"):
        equilibrium(system, held=["j7"])


def test_multipliers_of_the_highest_hinge_carry_the_weight(comm):
    system = MultibodySystem(comm, chain(4))
    state = equilibrium(system)
    force = state.multipliers[24:27]  # after the internal ones of four bodies
    assert np.allclose(force, [0.0, -9.81 * 10.0, 0.0], rtol=0, atol=1e-9)


def test_a_prescribed_displacement_is_displacement_control(comm):
    """The multiplier of the motion is the force of a spring that softens and turns."""
    joint = Cylindrical("j", None, A, point=(3.0, 5.0, 2.0), axis=N)
    spring = PointSpring(
        "s",
        A,
        None,
        first_point=(3.0, 5.0, 2.0),
        second_point=(6.0, 5.0, 2.0),
        stiffness=50.0,
        length=2.0,
    )
    lock = JointSpring("t", "j.angle", 10.0)
    system = MultibodySystem(
        comm, [A, joint, spring, lock, PrescribedMotion("j.displacement", lambda t: t)]
    )
    state = None
    for way in (0.5, -1.0, 1.5):
        state = equilibrium(system, [way], state)
        assert state.joint_coordinates[1] == pytest.approx(way, abs=1e-13) and state.time == way
        gap = np.array([3.0, 0.0, 0.0]) - way * N
        length = np.linalg.norm(gap)
        force = -50.0 * (length - 2.0) * gap @ N / length  # of the drive, along the axis
        assert state.multipliers[-1] == pytest.approx(-force, rel=1e-10)


def test_a_motion_of_several_turns_needs_load_steps(comm):
    hinge = Revolute("hinge", None, A, point=(3.0, 6.0, 2.0), axis=N)
    system = MultibodySystem(comm, [A, hinge, PrescribedMotion("hinge", lambda t: 10.0 * t)])
    state = equilibrium(system, np.linspace(0.1, 1.0, 10))
    R = rotation_about(N, 10.0)
    assert state.joint_coordinates[0] == pytest.approx(10.0, abs=1e-13)
    assert np.allclose(state.q[3:].reshape(3, 3).T, R @ np.asarray(A.directors), rtol=0, atol=1e-12)
    for end in (0.3, 0.4, 1.0):  # 3, 4, 10 rad at once end on another branch
        words = "a joint turned by half a revolution or more in one load step, or a redundant"
        with pytest.raises(StepFailure, match=f"no equilibrium at t = {end:g} s: {words}"):
            equilibrium(system, [end])


def test_a_torque_that_winds_a_spring_up_over_turns(comm):
    hinge = Revolute("hinge", None, A, point=(3.0, 6.0, 2.0), axis=N)
    parts = [
        A,
        hinge,
        JointSpring("s", "hinge", 2.0),
        JointTorque("torque on hinge", "hinge", 1.0, lambda t: 20.0 * t),
    ]
    state = equilibrium(MultibodySystem(comm, parts), np.linspace(0.05, 1.0, 20))
    assert state.joint_coordinates[0] == pytest.approx(10.0, rel=1e-12)
    assert np.allclose(state.q[3:6], rotation_about(N, 10.0) @ np.asarray(A.directors)[:, 0])


def test_follower_and_point_forces_in_space(comm):
    """A body on a ball joint, held by three springs."""
    ball = Spherical("ball", None, A, (3.0, 6.0, 2.0))
    springs = [
        PointSpring(
            f"s{k}",
            None,
            A,
            first_point=10 * e + A.position,
            second_point=A.position,
            stiffness=30.0,
        )
        for k, e in enumerate(np.eye(3))
    ]
    loads = [
        Gravity(),
        PointForce("f", A, point=(4, 5, 2), force=(3, 0, -4), function=lambda t: t),
        FollowerForce("g", A, point=(3, 5, 4), force=(0, 4, 1), function=lambda t: t),
    ]
    system = MultibodySystem(comm, [A, ball, *springs, *loads])
    state = equilibrium(system, [0.5, 1.0])
    assert np.max(np.abs(state.q - A.coordinates)) > 0.05
    # the follower force is not conservative: moments about the joint balance by hand
    q = state.q.reshape(4, 3)

    def at(point):
        return q[0] + A.body_coordinates(point) @ q[1:]

    moments = [np.cross(at((4, 5, 2)) - at(ball.point), (3, 0, -4))]
    turned = (np.array([0, 4, 1.0]) @ np.asarray(A.directors)) @ q[1:]
    moments.append(np.cross(at((3, 5, 4)) - at(ball.point), turned))
    moments.append(np.cross(q[0] - at(ball.point), 2.0 * np.array([0, -9.81, 0])))
    for s in springs:
        gap = np.asarray(s.first_point) - q[0]
        length = np.linalg.norm(gap)
        moments.append(np.cross(q[0] - at(ball.point), 30.0 * (length - 10.0) * gap / length))
    assert np.max(np.abs(sum(moments))) <= 1e-9


def test_the_number_of_iterations_is_logged(comm, caplog):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    with caplog.at_level(logging.INFO, logger="turbine_fenicsx"):
        equilibrium(system, [1.0])
    assert re.fullmatch(r"equilibrium at t = 1 s after \d+ iterations", caplog.messages[-1])


# --- what does not work


def test_a_free_body_has_no_equilibrium_under_its_weight(comm):
    words = r"no equilibrium at t = 2 s: the increments of Newton's method .* more load steps may"
    with pytest.raises(StepFailure, match=words):
        equilibrium(MultibodySystem(comm, [A, Gravity()]), [2.0])


def test_the_start_is_not_changed_by_success_or_failure(comm):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    start = system.initial_state()
    start.q_dot[:] = 1.0
    before = start.q.copy()
    state = equilibrium(system, state=start)
    assert np.array_equal(start.q, before) and np.all(start.q_dot == 1.0)
    assert np.all(state.q_dot == 0.0)
    with pytest.raises(StepFailure):
        equilibrium(system, state=start, max_iterations=1)
    assert np.array_equal(start.q, before)


def test_no_load_steps_leave_the_initial_state(comm):
    system = MultibodySystem(comm, [A, HINGE, Gravity()])
    assert np.array_equal(equilibrium(system, []).q, A.coordinates)
