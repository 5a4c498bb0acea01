"""Claims about the block of rigid bodies, joints and angles in one step, far from equilibrium."""

import numpy as np
import pytest

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints import Revolute
from turbine_fenicsx.joints.augmented_angle import FORMS

FORM_NAMES = ("regular", "paper")
DT = 0.1
A = RigidBody("a", 2.0, (1, 2, 3), (1, 0, 0), rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 0.3), (1, 2, 0), rotation_about((0, 1, 2), -1.9))
JOINTS = (
    Revolute("first", None, A, (0, 0, 0), (1.0, 0.2, 3.0)),
    Revolute("second", A, B, (1, 1, 0), (0.3, 1.0, 0.0)),
)
N_Q, N_T, N_G = 24, 2, 22


def functions():
    frames = {A: BodyFrame(A, 0), B: BodyFrame(B, 4), None: BodyFrame(None)}
    constraints = [c for b in (A, B) for c in frames[b].internal_constraints()]
    angles = []
    for j in JOINTS:
        pair = [frames[b] for b in j.bodies]
        constraints += j.constraints(*pair)
        angles += j.coordinates(*pair).values()
    return constraints, angles


def block(form):
    return RigidBlock(np.concatenate([A.masses, B.masses]), *functions(), FORMS[form])


def arbitrary(seed, size=1.0):
    """A step and unknowns that fulfil nothing."""
    rng = np.random.default_rng(seed)
    step = RigidStep(
        q=rng.normal(size=N_Q),
        angles=rng.uniform(-7, 7, N_T),
        dt_q_dot=rng.normal(size=N_Q),
        impulse_q=rng.normal(size=N_Q),
        impulse_T=rng.normal(size=N_T),
    )
    return step, rng.normal(size=N_Q + N_T + N_G + N_T) * size


@pytest.mark.parametrize("form", FORM_NAMES)
def test_unknowns_are_increments_then_multipliers(form):
    b = block(form)
    assert (b.n_q, b.n_angles, b.n_constraints, b.size) == (N_Q, N_T, N_G, 50)
    r = np.arange(50.0)
    x = b.split(r)
    assert [part.size for part in x] == [N_Q, N_T, N_G, N_T, 0]
    assert np.array_equal(np.concatenate(x), r)


@pytest.mark.parametrize("form", FORM_NAMES)
def test_residual_is_the_step_written_down_term_by_term(form):
    b, (step, r) = block(form), arbitrary(1)
    dq, dT, mu, nu = np.split(r, np.cumsum([N_Q, N_T, N_G]))
    constraints, angles = functions()
    rows = (constraints, [a.cosine for a in angles], [a.sine for a in angles])
    g, c, s = (QuadraticMap(f, N_Q) for f in rows)
    q1, T1, q_mid = step.q + dq, step.angles + dT, step.q + 0.5 * dq
    a = FORMS[form](step.angles, T1, c.value(step.q), c.value(q1), s.value(step.q), s.value(q1))
    joint = c.jacobian(q_mid).T @ (a.g_c * nu) + s.jacobian(q_mid).T @ (a.g_s * nu)
    expected = np.concatenate(
        [
            b.masses * (dq - step.dt_q_dot) + g.jacobian(q_mid).T @ mu + joint - step.impulse_q,
            a.g_T * nu - step.impulse_T,
            g.value(q1),
            a.Phi,
        ]
    )
    R, scale = b.residual(step, r)
    assert np.all(np.abs(R - expected) <= 1e-14 * scale)  # a dozen operations each
    scale[-N_T:] += 2.0  # cosine and sine of the angle itself, which equal c and s once solved
    assert np.all(np.abs(R) <= scale * (1 + 1e-14))


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_residual_along_the_increment_is_the_balance_of_energy(form, size):
    """dq.R_q + dT.R_T = dt^2/2 (kinetic energy - work) + mu.(g1 - g0) + nu.(Phi1 - Phi0) for any
    unknowns: once R = 0 and the constraints hold at both ends, energy grows by the work only."""
    b, (step, r) = block(form), arbitrary(2, size)
    x = b.split(r)
    R, scale = b.residual(step, r)
    v0 = step.dt_q_dot / DT
    v1 = 2 * x.dq / DT - v0
    kinetic = 0.5 * (v1 @ (b.masses * v1) - v0 @ (b.masses * v0))
    work = (step.impulse_q @ x.dq + step.impulse_T @ x.dT) / (0.5 * DT**2)
    before = b.constraint_values(step.q, step.angles)
    after = b.constraint_values(step.q + x.dq, step.angles + x.dT)
    balance = 0.5 * DT**2 * (kinetic - work) + np.concatenate([x.mu, x.nu]) @ (after - before)
    lhs = x.dq @ R[:N_Q] + x.dT @ R[N_Q : N_Q + N_T]
    # round-off of every term that entered, and of the velocities' squares
    terms = np.abs(r[: N_Q + N_T]) @ scale[: N_Q + N_T] + b.masses @ (step.dt_q_dot**2)
    assert abs(lhs - balance) <= 1e-14 * terms


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_rigid_tangent_agrees_with_finite_differences(form, size):
    b, (step, r) = block(form), arbitrary(3, size)
    h = 1e-5
    columns = [
        (b.residual(step, r + h * e)[0] - b.residual(step, r - h * e)[0]) / (2 * h)
        for e in np.eye(b.size)
    ]
    K = b.tangent(step, r)
    # h^2/6 times third derivatives and 1e-16/h, with terms up to 50 in size
    assert np.allclose(K, np.column_stack(columns), rtol=0, atol=1e-8)


@pytest.mark.parametrize("form", FORM_NAMES)
def test_constraints_vanish_initially(form):
    b = block(form)
    q = np.concatenate([A.coordinates, B.coordinates])
    assert np.max(np.abs(b.constraint_values(q, np.zeros(N_T)))) <= 1e-15
    shifted = q.copy()
    shifted[0] += 1e-3  # A off both bearings
    values = b.constraint_values(shifted, np.zeros(N_T))
    assert np.count_nonzero(np.abs(values) > 1e-4) == 2
    turned = b.constraint_values(q, np.array([0.0, 0.2]))
    assert np.flatnonzero(np.abs(turned) > 1e-15).tolist() == [N_G + 1]


@pytest.mark.parametrize("form", FORM_NAMES)
def test_constraints_do_not_depend_on_what_was_evaluated_before(form):
    """They are taken from the last evaluation only if configuration and angles are the same."""
    b, (step, r) = block(form), arbitrary(6)
    x = b.split(r)
    q, T = step.q + x.dq, step.angles + x.dT
    for q_seen, T_seen in ((q, T), (q, T + 0.1), (step.q, T), (q, step.angles)):
        b.residual(step, r)
        expected = block(form).constraint_values(q_seen, T_seen)
        assert np.array_equal(b.constraint_values(q_seen, T_seen), expected)


def test_evaluations_are_pure():
    b, (step, r) = block("regular"), arbitrary(4)
    before = [np.copy(x) for x in (step.q, step.angles, step.dt_q_dot, r)]
    first = [*b.residual(step, r), b.tangent(step, r)]
    again = [*b.residual(step, r), b.tangent(step, r)]
    assert all(np.array_equal(x, y) for x, y in zip(first, again, strict=True))
    after = (step.q, step.angles, step.dt_q_dot, r)
    assert all(np.array_equal(x, y) for x, y in zip(before, after, strict=True))


def test_a_solution_on_the_wrong_branch_is_not_acceptable():
    b = block("regular")
    q = np.concatenate([A.coordinates, B.coordinates])
    zero = np.zeros(N_Q)
    step = RigidStep(q, np.zeros(N_T), zero, zero, np.zeros(N_T))
    r = np.zeros(b.size)
    assert b.acceptable(step, r)
    for k in range(N_T):
        r[:] = 0.0
        b.split(r).dT[k] = np.pi  # another root of the constraint
        assert np.max(np.abs(b.residual(step, r)[0])) <= 1e-15
        assert not b.acceptable(step, r)


def test_a_block_without_bodies_or_angles_is_empty():
    b = RigidBlock(np.zeros(0), [], [], FORMS["regular"])
    nothing = np.zeros(0)
    step = RigidStep(nothing, nothing, nothing, nothing, nothing)
    assert b.size == 0
    assert b.residual(step, nothing)[0].shape == (0,)
    assert b.tangent(step, nothing).shape == (0, 0)
    assert b.acceptable(step, nothing)
