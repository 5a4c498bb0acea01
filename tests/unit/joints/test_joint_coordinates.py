"""Claims about joint coordinates of both kinds in one block, with motions and force elements."""

import numpy as np
import pytest

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.forces import (
    FollowerForce,
    JointDamper,
    JointSpring,
    JointTorque,
    PointDamper,
    PointSpring,
    Torque,
)
from turbine_fenicsx.forces.element import Layout, Step
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints import Cylindrical, Planar, Revolute
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.joints.coordinates import augmentation
from turbine_fenicsx.system.rigid_block import RigidBlock, RigidStep
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.solver import EnergyMomentumSolver

DT = 0.1
A = RigidBody("a", 2.0, (1, 2, 3), (1, 0, 0), rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 0.3), (1, 2, 0), rotation_about((0, 1, 2), -1.9))
JOINTS = (
    Cylindrical("first", None, A, (0, 0, 0), (1.0, 0.2, 3.0)),
    Planar("second", A, B, (1, 1, 0), (0.3, 1.0, 0.0)),
)
IS_ANGLE = np.array([True, False, False, False, True])
NAMES = ("first.angle", "first.displacement", "second.first", "second.second", "second.angle")
N_Q, N_T, N_G = 24, 5, 19
LAYOUT = Layout({A: 0, B: 12}, {name: N_Q + k for k, name in enumerate(NAMES)})
PRESCRIBED = (1, 4)
ELEMENTS = (
    JointSpring("s", "second.first", 3.0, 0.2),
    JointDamper("d", "first.displacement", 2.0),
    PointSpring("p", A, B, (1, 0, 2), (0, 1, 0), 5.0, 0.5),
    PointDamper("q", None, B, (1, 0, 2), (0, 1, 0), 0.7),
    FollowerForce("f", A, (0, 1, 0), (1, 2, -1)),
    Torque("t", B, (0.5, 1, -1), follower=True),
    Torque("u", B, (0.5, -1, 2)),
)


def block(form="regular"):
    frames = {A: BodyFrame(A, 0), B: BodyFrame(B, 4), None: BodyFrame(None)}
    constraints = [c for b in (A, B) for c in frames[b].internal_constraints()]
    coordinates = {}
    for j in JOINTS:
        pair = [frames[b] for b in j.bodies]
        constraints += j.constraints(*pair)
        coordinates |= j.coordinates(*pair)
    assert tuple(coordinates) == NAMES
    return RigidBlock(
        np.concatenate([A.masses, B.masses]),
        constraints,
        list(coordinates.values()),
        FORMS[form],
        PRESCRIBED,
        [e.bind(LAYOUT) for e in ELEMENTS],
    )


def arbitrary(b, seed, size=1.0):
    """A step and unknowns that fulfil nothing; directors are far from singular."""
    rng = np.random.default_rng(seed)
    step = RigidStep(
        q=np.concatenate([A.coordinates, B.coordinates]) + 0.3 * rng.normal(size=N_Q),
        angles=rng.uniform(-7, 7, N_T),
        dt_q_dot=rng.normal(size=N_Q),
        impulse_q=rng.normal(size=N_Q),
        impulse_T=rng.normal(size=N_T),
        prescribed=rng.normal(size=len(PRESCRIBED)),
        elements=Step(DT, 0.4),
    )
    r = rng.normal(size=b.size) * size
    r[:N_Q] *= 0.3
    return step, r


def test_both_kinds_are_numbered_in_the_order_of_the_joints():
    b = block()
    assert (b.n_q, b.n_angles, b.n_constraints, b.n_prescribed) == (N_Q, N_T, N_G, 2)
    assert np.array_equal(b.is_angle, IS_ANGLE)
    assert [x.size for x in b.split(np.arange(float(b.size)))] == [N_Q, N_T, N_G, N_T, 2]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_tangent_agrees_with_finite_differences(form, size):
    b = block(form)
    (step, r), h = arbitrary(b, 3, size), 1e-5
    columns = [
        (b.residual(step, r + h * e)[0] - b.residual(step, r - h * e)[0]) / (2 * h)
        for e in np.eye(b.size)
    ]
    # h^2/6 times third derivatives and 1e-16/h, with terms up to 100 in size
    assert np.allclose(b.tangent(step, r), np.column_stack(columns), rtol=0, atol=3e-8)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_residual_along_the_increment_is_the_balance_of_energy(form, size):
    """For any unknowns: once R = 0 and all constraints hold at both ends, energy grows by works."""
    b = block(form)
    step, r = arbitrary(b, 2, size)
    x = b.split(r)
    R, scale = b.residual(step, r)
    v0 = step.dt_q_dot / DT
    v1 = 2 * x.dq / DT - v0
    kinetic = 0.5 * (v1 @ (b.masses * v1) - v0 @ (b.masses * v0))
    work = (step.impulse_q @ x.dq + step.impulse_T @ x.dT) / (0.5 * DT**2)
    work += b.element_works(step, r).sum() - x.pi @ x.dT[list(PRESCRIBED)] / (0.5 * DT**2)
    before = b.constraint_values(step.q, step.angles)
    after = b.constraint_values(step.q + x.dq, step.angles + x.dT)
    balance = 0.5 * DT**2 * (kinetic - work) + np.concatenate([x.mu, x.nu]) @ (after - before)
    n = N_Q + N_T
    terms = np.abs(r[:n]) @ scale[:n] + b.masses @ step.dt_q_dot**2
    assert abs(r[:n] @ R[:n] - balance) <= 1e-14 * terms


def test_works_of_springs_are_the_loss_of_their_energy():
    b = block()
    step, r = arbitrary(b, 5)
    x, works = b.split(r), b.element_works(step, r)
    energies = [b.element_energy(step.q + s * x.dq, step.angles + s * x.dT) for s in (0.0, 1.0)]
    springs = [e.kind == "conservative" for e in ELEMENTS]
    assert works[springs].sum() == pytest.approx(energies[0] - energies[1], rel=1e-13)
    assert np.all(works[[e.kind == "dissipative" for e in ELEMENTS]] < 0.0)


@pytest.mark.parametrize("form", FORMS)
def test_the_scale_bounds_all_terms(form):
    b = block(form)
    for seed in range(4):
        R, scale = b.residual(*arbitrary(b, seed))
        scale[N_Q + N_T + N_G : N_Q + 2 * N_T + N_G] += 14.0  # the coordinates themselves
        scale[-2:] += 14.0
        assert np.all(np.abs(R) <= scale * (1 + 1e-14))


@pytest.mark.parametrize("form", FORMS)
def test_discrete_gradient_of_both_kinds_is_directional(form):
    terms, rng = augmentation(FORMS[form], IS_ANGLE), np.random.default_rng(7)
    for size in (1.0, 1e-4, 0.0):
        T0, c0, s0 = rng.uniform(-3, 3, (3, N_T))
        T1, c1, s1 = (x + size * rng.normal(size=N_T) for x in (T0, c0, s0))
        a, start = terms(T0, T1, c0, c1, s0, s1), terms(T0, T0, c0, c0, s0, s0)
        change = a.g_c * (c1 - c0) + a.g_s * (s1 - s0) + a.g_T * (T1 - T0)
        assert np.allclose(change, a.Phi - start.Phi, rtol=0, atol=1e-14)


def test_a_displacement_equals_its_function_and_needs_no_sine():
    terms = augmentation(FORMS["regular"], IS_ANGLE)
    T = np.array([0.3, 1.7, -2.0, 5.0, -0.4])
    c, s = np.where(IS_ANGLE, np.cos(T), T), np.where(IS_ANGLE, np.sin(T), 99.0)
    a = terms(T, T, c, c, s, s)
    assert np.max(np.abs(a.Phi)) <= 1e-15
    assert np.allclose(a.Phi_T, 1.0, rtol=0, atol=1e-15)


def test_angles_alone_are_as_they_were():
    """No other code runs for them, so that results stay bit for bit."""
    assert augmentation(FORMS["regular"], np.array([True, True])) is FORMS["regular"]


def test_a_displacement_may_grow_by_any_length_in_a_step_and_an_angle_may_not():
    b = block()
    q = np.concatenate([A.coordinates, B.coordinates])
    zero = np.zeros(N_Q)
    step = RigidStep(q, np.zeros(N_T), zero, zero, np.zeros(N_T), np.zeros(2))
    for k in range(N_T):
        r = np.zeros(b.size)
        b.split(r).dT[k] = 1.6  # more than a quarter of a revolution
        assert b.acceptable(step, r) == (not IS_ANGLE[k])


def test_a_screw_motion_is_followed_over_several_turns(comm):
    """Angle and displacement of a body that a force along and a torque about its axis drive."""
    n = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    joint = Cylindrical("j", None, A, (0.2, 0.1, 0.0), n)
    spring = JointSpring("s", "j.displacement", 4.0)
    loads = [
        JointTorque("torque on j.angle", "j.angle", 1.0, lambda t: 30.0),
        JointTorque("torque on j.displacement", "j.displacement", 1.0, lambda t: 4.0),
    ]
    system = MultibodySystem(comm, [A, joint, spring, *loads])
    solver = EnergyMomentumSolver(system)
    state = system.initial_state()
    other = state.copy()
    along = []
    for _ in range(100):
        solver.advance(state, 0.05, other)
        state, other = other, state
        angle, way = state.angles
        R = rotation_about(n, angle)
        expected = R @ (np.asarray(A.position) - joint.point) + joint.point + way * n
        assert np.allclose(state.q[:3], expected, rtol=0, atol=1e-11)
        assert np.allclose(state.q[3:6], R @ np.asarray(A.directors)[:, 0], rtol=0, atol=1e-11)
        along.append(way)
    solver.destroy()
    assert angle > 6 * np.pi
    # 2 kg on 4 N/m under 4 N: about 1 m to and fro, in trapezoidal steps 1 - cos(w t)
    w = 2 / 0.05 * np.arctan(0.5 * 0.05 * np.sqrt(2.0))
    times = 0.05 * np.arange(1, 101)
    assert np.allclose(along, 1 - np.cos(w * times), rtol=0, atol=1e-10)


def test_two_joints_may_not_make_coordinates_of_the_same_name(comm):
    twin = Revolute("first.angle", A, B, (1, 1, 0), (0.3, 1.0, 0.0))
    with pytest.raises(ValueError, match=r"two joint coordinates are called 'first\.angle'"):
        MultibodySystem(comm, [A, B, JOINTS[0], twin])
