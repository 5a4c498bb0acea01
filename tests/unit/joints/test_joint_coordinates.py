"""Claims about joint coordinates of both kinds in one step, with relations and forces."""

import numpy as np
import pytest
from rigid_models import ELEMENTS, N_Q, RELATIONS, SLIDES, A, B, constraint_values, sliding

from turbine_fenicsx import Cylindrical, JointSpring, JointTorque, Revolute, StepTimes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.joints.coordinates import augmentation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.rigid_step import RigidData, RigidStep

DT = 0.1
IS_ANGLE = np.array([True, False, False, False, True])
N_T, N_G = 5, 19


def block(form="regular"):
    """A step, and the model in it."""
    m = sliding()
    return RigidStep(m, FORMS[form]), m


def arbitrary(m, seed, size=1.0):
    """A step and unknowns that fulfil nothing; directors are far from singular."""
    rng = np.random.default_rng(seed)
    data = RigidData(
        q=np.concatenate([A.coordinates, B.coordinates]) + 0.3 * rng.normal(size=N_Q),
        T=rng.uniform(-7, 7, N_T),
        dt_q_dot=rng.normal(size=N_Q),
        impulse_q=rng.normal(size=N_Q),
        impulse_T=rng.normal(size=N_T),
        prescribed=rng.normal(size=len(RELATIONS)),
        times=StepTimes.from_start(0.4 - 0.5 * DT, DT),
    )
    r = rng.normal(size=m.size) * size
    r[:N_Q] *= 0.3
    return data, r


def test_both_kinds_are_numbered_in_the_order_of_the_joints():
    _, m = block()
    assert (m.n_q, m.n_T, m.n_constraints, m.n_relations) == (N_Q, N_T, N_G, 2)
    assert np.array_equal(m.is_angle, IS_ANGLE)
    assert [x.size for x in m.split(np.arange(float(m.size)))] == [N_Q, N_T, N_G, N_T, 2]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_tangent_agrees_with_finite_differences(form, size):
    b, m = block(form)
    (data, r), h = arbitrary(m, 3, size), 1e-5
    columns = [
        (b.residual(data, r + h * e)[0] - b.residual(data, r - h * e)[0]) / (2 * h)
        for e in np.eye(m.size)
    ]
    # h^2/6 times third derivatives and 1e-16/h, with terms up to 100 in size
    assert np.allclose(b.tangent(data, r), np.column_stack(columns), rtol=0, atol=3e-8)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_residual_along_the_increment_is_the_balance_of_energy(form, size):
    """For any unknowns: once R = 0 and all constraints hold at both ends, energy grows by works."""
    b, m = block(form)
    data, r = arbitrary(m, 2, size)
    x = m.split(r)
    R, scale = b.residual(data, r)
    v0 = data.dt_q_dot / DT
    v1 = 2 * x.dq / DT - v0
    kinetic = 0.5 * (v1 @ (m.masses * v1) - v0 @ (m.masses * v0))
    work = (data.impulse_q @ x.dq + data.impulse_T @ x.dT) / (0.5 * DT**2)
    work += b.motion_works(data, r).sum() - x.pi @ RELATIONS @ x.dT / (0.5 * DT**2)
    before = constraint_values(m, FORMS[form], data.q, data.T)
    after = constraint_values(m, FORMS[form], data.q + x.dq, data.T + x.dT)
    balance = 0.5 * DT**2 * (kinetic - work) + np.concatenate([x.mu, x.nu]) @ (after - before)
    n = N_Q + N_T
    terms = np.abs(r[:n]) @ scale[:n] + m.masses @ data.dt_q_dot**2
    assert abs(r[:n] @ R[:n] - balance) <= 1e-14 * terms


def test_works_of_springs_are_the_loss_of_their_energy():
    b, m = block()
    data, r = arbitrary(m, 5)
    x, works = m.split(r), b.motion_works(data, r)
    energies = [m.spring_energy(data.q + s * x.dq, data.T + s * x.dT) for s in (0.0, 1.0)]
    springs = [e.kind == "conservative" for e in ELEMENTS]
    assert works[springs].sum() == pytest.approx(energies[0] - energies[1], rel=1e-13)
    assert np.all(works[[e.kind == "dissipative" for e in ELEMENTS]] < 0.0)


@pytest.mark.parametrize("form", FORMS)
def test_the_scale_bounds_all_terms(form):
    b, m = block(form)
    for seed in range(4):
        R, scale = b.residual(*arbitrary(m, seed, size=1e-3))
        scale[N_Q + N_T + N_G : N_Q + 2 * N_T + N_G] += 14.0  # the coordinates themselves
        scale[-2:] += 14.0
        assert np.all(np.abs(R) <= scale * (1 + 1e-2))  # of factors at the start of the step


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
    b, m = block()
    q = np.concatenate([A.coordinates, B.coordinates])
    zero = np.zeros(N_Q)
    data = RigidData(q, np.zeros(N_T), zero, zero, np.zeros(N_T), np.zeros(2))
    for k in range(N_T):
        r = np.zeros(m.size)
        m.split(r).dT[k] = 1.6  # more than a quarter of a revolution
        assert b.is_acceptable(data, r) == (not IS_ANGLE[k])


def test_a_screw_motion_is_followed_over_several_turns(comm):
    """Angle and displacement of a body that a force along and a torque about its axis drive."""
    n = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    joint = Cylindrical("j", None, A, point=(0.2, 0.1, 0.0), axis=n)
    spring = JointSpring("s", "j.displacement", 4.0)
    loads = [
        JointTorque("torque on j.angle", "j.angle", 1.0, lambda t: 30.0),
        JointTorque("torque on j.displacement", "j.displacement", 1.0, lambda t: 4.0),
    ]
    system = MultibodySystem(comm, [A, joint, spring, *loads])
    solver = EnergyMomentum(system)
    state = system.initial_state()
    other = state.copy()
    along = []
    for _ in range(100):
        solver.advance(state, 0.05, other)
        state, other = other, state
        angle, way = state.joint_coordinates
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
    twin = Revolute("first.angle", A, B, point=(1, 1, 0), axis=(0.3, 1.0, 0.0))
    with pytest.raises(ValueError, match=r"two joint coordinates are called 'first\.angle'"):
        MultibodySystem(comm, [A, B, SLIDES[0], twin])
