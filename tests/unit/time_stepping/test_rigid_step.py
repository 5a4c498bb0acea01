"""Claims about rigid bodies, joints and angles in one step, far from equilibrium."""

import numpy as np
import pytest
from rigid_models import HINGES, N_Q, A, B, constraint_values, functions, hinged

from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.system.rigid_model import RigidModel
from turbine_fenicsx.time_stepping.rigid_step import RigidData, RigidStep

FORM_NAMES = ("regular", "paper")
DT = 0.1
N_T, N_G = 2, 22


def block(form):
    """A step, and the model in it."""
    m = hinged()
    return RigidStep(m, FORMS[form]), m


def arbitrary(seed, size=1.0):
    """Data and unknowns that fulfil nothing."""
    rng = np.random.default_rng(seed)
    data = RigidData(
        q=rng.normal(size=N_Q),
        T=rng.uniform(-7, 7, N_T),
        dt_q_dot=rng.normal(size=N_Q),
        impulse_q=rng.normal(size=N_Q),
        impulse_T=rng.normal(size=N_T),
    )
    return data, rng.normal(size=N_Q + N_T + N_G + N_T) * size


@pytest.mark.parametrize("form", FORM_NAMES)
def test_residual_is_the_step_written_down_term_by_term(form):
    b, m, (data, r) = *block(form), arbitrary(1)
    dq, dT, mu, nu = np.split(r, np.cumsum([N_Q, N_T, N_G]))
    constraints, coordinates = functions(HINGES)
    angles = list(coordinates.values())
    rows = (constraints, [a.cosine for a in angles], [a.sine for a in angles])
    g, c, s = (QuadraticMap(f, N_Q) for f in rows)
    q1, T1, q_mid = data.q + dq, data.T + dT, data.q + 0.5 * dq
    a = FORMS[form](data.T, T1, c.value(data.q), c.value(q1), s.value(data.q), s.value(q1))
    joint = c.jacobian(q_mid).T @ (a.g_c * nu) + s.jacobian(q_mid).T @ (a.g_s * nu)
    expected = np.concatenate(
        [
            m.masses * (dq - data.dt_q_dot) + g.jacobian(q_mid).T @ mu + joint - data.impulse_q,
            a.g_T * nu - data.impulse_T,
            g.value(q1),
            a.Phi,
        ]
    )
    R, scale = b.residual(data, r)
    assert np.all(np.abs(R - expected) <= 2e-14 * scale)  # a dozen operations each
    data, r = arbitrary(1, size=1e-3)
    R, scale = b.residual(data, r)
    scale[-N_T:] += 2.0  # cosine and sine of the angle itself, which equal c and s once solved
    assert np.all(np.abs(R) <= scale * (1 + 1e-2))  # of factors at the start of the step


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_residual_along_the_increment_is_the_balance_of_energy(form, size):
    """dq.R_q + dT.R_T = dt^2/2 (kinetic energy - work) + mu.(g1 - g0) + nu.(Phi1 - Phi0) for any
    unknowns: once R = 0 and the constraints hold at both ends, energy grows by the work only."""
    b, m, (data, r) = *block(form), arbitrary(2, size)
    x = m.split(r)
    R, scale = b.residual(data, r)
    v0 = data.dt_q_dot / DT
    v1 = 2 * x.dq / DT - v0
    kinetic = 0.5 * (v1 @ (m.masses * v1) - v0 @ (m.masses * v0))
    work = (data.impulse_q @ x.dq + data.impulse_T @ x.dT) / (0.5 * DT**2)
    before = constraint_values(m, FORMS[form], data.q, data.T)
    after = constraint_values(m, FORMS[form], data.q + x.dq, data.T + x.dT)
    balance = 0.5 * DT**2 * (kinetic - work) + np.concatenate([x.mu, x.nu]) @ (after - before)
    lhs = x.dq @ R[:N_Q] + x.dT @ R[N_Q : N_Q + N_T]
    # round-off of every term that entered, and of the velocities' squares
    terms = np.abs(r[: N_Q + N_T]) @ scale[: N_Q + N_T] + m.masses @ (data.dt_q_dot**2)
    assert abs(lhs - balance) <= 1e-14 * terms


@pytest.mark.parametrize("form", FORM_NAMES)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_rigid_tangent_agrees_with_finite_differences(form, size):
    b, m, (data, r) = *block(form), arbitrary(3, size)
    h = 1e-5
    columns = [
        (b.residual(data, r + h * e)[0] - b.residual(data, r - h * e)[0]) / (2 * h)
        for e in np.eye(m.size)
    ]
    K = b.tangent(data, r)
    # h^2/6 times third derivatives and 1e-16/h, with terms up to 50 in size
    assert np.allclose(K, np.column_stack(columns), rtol=0, atol=1e-8)


@pytest.mark.parametrize("form", FORM_NAMES)
def test_constraints_do_not_depend_on_what_was_evaluated_before(form):
    """They are taken from the last evaluation only if configuration and angles are the same."""
    b, m, (data, r) = *block(form), arbitrary(6)
    x = m.split(r)
    q, T = data.q + x.dq, data.T + x.dT
    for q_seen, T_seen in ((q, T), (q, T + 0.1), (data.q, T), (q, data.T)):
        b.residual(data, r)
        expected = hinged().constraint_values(q_seen, T_seen)
        assert np.array_equal(m.constraint_values(q_seen, T_seen), expected)


def test_evaluations_are_pure():
    b, _, (data, r) = *block("regular"), arbitrary(4)
    before = [np.copy(x) for x in (data.q, data.T, data.dt_q_dot, r)]
    first = [*b.residual(data, r), b.tangent(data, r)]
    again = [*b.residual(data, r), b.tangent(data, r)]
    assert all(np.array_equal(x, y) for x, y in zip(first, again, strict=True))
    after = (data.q, data.T, data.dt_q_dot, r)
    assert all(np.array_equal(x, y) for x, y in zip(before, after, strict=True))


def test_a_solution_on_the_wrong_branch_is_not_acceptable():
    b, m = block("regular")
    q = np.concatenate([A.coordinates, B.coordinates])
    zero = np.zeros(N_Q)
    data = RigidData(q, np.zeros(N_T), zero, zero, np.zeros(N_T))
    r = np.zeros(m.size)
    assert b.is_acceptable(data, r)
    for k in range(N_T):
        r[:] = 0.0
        m.split(r).dT[k] = np.pi  # another root of the constraint
        assert np.max(np.abs(b.residual(data, r)[0])) <= 1e-15
        assert not b.is_acceptable(data, r)


def test_a_step_without_bodies_or_angles_is_empty():
    m = RigidModel(np.zeros(0), [], [])
    b = RigidStep(m, FORMS["regular"])
    nothing = np.zeros(0)
    data = RigidData(nothing, nothing, nothing, nothing, nothing)
    assert m.size == 0
    assert b.residual(data, nothing)[0].shape == (0,)
    assert b.tangent(data, nothing).shape == (0, 0)
    assert b.is_acceptable(data, nothing)
