"""Claims about the nested blocks of one step of flexible and rigid bodies, joints and angles.

The identities hold for arbitrary states and unknowns, so they are checked far from any solution,
where nothing vanishes by accident.
"""

from functools import partial

import numpy as np
import pytest
from rigid_models import constraint_values
from wild_steps import DT, T0, begun, loaded, wild_state, wild_unknowns

from turbine_fenicsx import Gravity, Hat, JointTorque
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.time_stepping.first_guess import mean_turns

HALF_DT2 = 0.5 * DT**2
EPS = np.finfo(float).eps
KINDS = [
    ("hexahedron", 1, "svk"),
    ("hexahedron", 2, "neo_hooke"),
    ("tetrahedron", 1, "neo_hooke"),
    ("tetrahedron", 2, "svk"),
]
all_kinds = pytest.mark.parametrize(("cell", "degree", "law"), KINDS)


def residual_at(step, x):
    R = step.new_nested_vector()
    step.residual(x, R)
    return R


def rigid_part(step, x):
    """r on all ranks, split."""
    comm, part = step.system.comm, step.split(x)[2]
    return step.system.rigid_model.split(comm.bcast(np.array(part.array_r)))


def gap_power(step, state, weights):
    """Sum over all nodes of coupling values times the gaps of a state."""
    system = step.system
    coordinates = system.coordinates_of(state.q)
    local = sum(
        weight.array_r @ c.gap(coordinates, u)
        for weight, c, u in zip(weights, system.coupling_blocks, state.u, strict=True)
    )
    return system.comm.allreduce(local)


def test_unknowns_are_displacements_then_couplings_then_the_rigid_part(comm, machine):
    step = EnergyMomentumStep(loaded(machine))
    (du,), (mu_c,), r = step.split(step.x)
    assert [v.getSize() for v in (du, mu_c, r)] == [36, 12, 50]
    assert r.getLocalSize() == (50 if comm.rank == 0 else 0)
    assert step.tangent_matrix.getSize() == (98, 98)


@pytest.mark.parallel
@pytest.mark.parametrize("form", FORMS)
@all_kinds
def test_nested_tangent_agrees_with_finite_differences_of_the_residual(
    machine, form, cell, degree, law
):
    step, _ = begun(loaded(machine, cell=cell, degree=degree, law=law), form=form)
    step.tangent(step.x)
    direction, h = wild_unknowns(step, seed=20, sizes=(1.0, 1.0, 1.0)), 1e-6
    exact = step.new_nested_vector()
    step.tangent_matrix.mult(direction, exact)
    ends = []
    for sign in (1, -1):
        x = step.x.copy()
        x.axpy(sign * h, direction)
        ends.append(residual_at(step, x))
    difference = ends[0].copy()
    difference.axpy(-1.0, ends[1])
    difference.scale(0.5 / h)
    for computed, expected in zip(difference.getNestSubVecs(), exact.getNestSubVecs(), strict=True):
        # each block by itself: h^2 times third derivatives, round-off EPS/h
        size = expected.norm()
        computed.axpy(-1.0, expected)
        assert size > 0.1
        assert computed.norm() <= 1e-8 * size


def test_rows_of_constraints_are_their_values_at_the_end_of_the_step(machine):
    step, state = begun(loaded(machine))
    system, after = step.system, state.copy()
    step.finish(after)
    R = residual_at(step, step.x)
    (R_c,) = step.split(R)[1]
    gap = system.coupling_blocks[0].gap(system.coordinates_of(after.q), after.u[0])
    found = np.concatenate(rigid_part(step, R)[2:])
    expected = system.rigid_model.constraint_values(after.q, after.joint_coordinates)
    assert R_c.norm() > 0.1
    assert np.allclose(found, expected, rtol=0, atol=1e-14)
    assert np.allclose(R_c.array_r, gap, rtol=0, atol=1e-14)  # sums of numbers up to two
    assert np.min(np.abs(expected)) > 1e-6


@pytest.mark.parametrize("form", FORMS)
@all_kinds
def test_residual_along_the_unknowns_is_the_balance_of_energy(machine, form, cell, degree, law):
    """X . R = dt^2/2 (H_{n+1} - H_n - work) + multipliers . (constraints_{n+1} - constraints_n),
    for any X: where R = 0 and the constraints hold, energy changes by the work alone."""
    system = loaded(machine, cell=cell, degree=degree, law=law)
    step, state = begun(system, form=form)
    after = state.copy()
    works, _ = step.finish(after)
    work = works.sum()
    R = residual_at(step, step.x)
    R_q, R_T, *_ = rigid_part(step, R)
    dq, dT, mu, nu, _ = rigid_part(step, step.x)
    (du,), mu_c, _ = step.split(step.x)
    lhs = du.dot(step.split(R)[0][0]) + dq @ R_q + dT @ R_T
    ends = [system.balance(s) for s in (state, after)]
    model = system.rigid_model
    values = [
        constraint_values(model, FORMS[form], s.q, s.joint_coordinates) for s in (state, after)
    ]
    gaps = [gap_power(step, s, mu_c) for s in (state, after)]
    rhs = HALF_DT2 * (ends[1].total - ends[0].total - work)
    rhs += np.concatenate([mu, nu]) @ (values[1] - values[0]) + gaps[1] - gaps[0]
    scale = HALF_DT2 * sum(e.kinetic + e.strain + abs(e.potential) for e in ends) + 10.0
    assert abs(lhs - rhs) <= 50 * EPS * scale


@pytest.mark.parametrize("axis", range(3))
@all_kinds
def test_residual_along_rigid_motions_is_the_balance_of_momenta(
    comm, machine, cell, degree, law, axis
):
    """Without a joint to the ground: dt/2 times the changes of linear and angular momentum,
    less gravity, and the moment of coupling forces over open gaps. All else drops out."""
    m = machine(spin=2.0, cell=cell, degree=degree, law=law)
    g = np.array([1.0, -9.81, 0.5])
    parts = [p for p in m.parts if p is not m.yaw]
    system = MultibodySystem(comm, [*parts, Gravity(tuple(g))])
    step, state = begun(system)
    after = state.copy()
    step.finish(after)
    R = residual_at(step, step.x)
    R_u = step.split(R)[0][0].array_r.reshape(-1, 3)
    R_q = rigid_part(step, R).dq.reshape(-1, 3)
    mu_c = step.split(step.x)[1][0].array_r.reshape(-1, 3)
    block, coupling = system.flexible_models[0], system.coupling_blocks[0]
    x_mid = block.positions + 0.5 * (state.u[0].array_r + after.u[0].array_r).reshape(-1, 3)
    q_mid = 0.5 * (state.q + after.q).reshape(-1, 3)
    gap_mid = 0.5 * sum(
        coupling.gap(system.coordinates_of(s.q), s.u[0]).reshape(-1, 3) for s in (state, after)
    )
    weight = block.nodal_mass[:, None] * g
    rigid_weight = system.gravity_force(g).reshape(-1, 3)

    def over_all_nodes(local):
        return comm.allreduce(np.asarray(local).sum(axis=0))

    # the joint between nacelle and hub is open as well: its force acts at two points
    joint = m.rotor
    frames = {b: system.first_coordinate[b] // 3 for b in system.rigid_bodies}
    gap = sum(
        sign * (q_mid[frames[b]] + b.body_coordinates(joint.point) @ q_mid[frames[b] + 1 :][:3])
        for sign, b in zip((-1, 1), joint.bodies, strict=True)
    )
    joint_force = rigid_part(step, step.x).mu[12:15]

    ends = [system.balance(s) for s in (state, after)]
    force = over_all_nodes(R_u) + R_q[::4].sum(axis=0)
    force += HALF_DT2 * (over_all_nodes(weight) + rigid_weight.sum(axis=0))
    moment = over_all_nodes(np.cross(x_mid, R_u)) + np.cross(q_mid, R_q).sum(axis=0)
    moment += HALF_DT2 * over_all_nodes(np.cross(x_mid, weight))
    moment += HALF_DT2 * np.cross(q_mid, rigid_weight).sum(axis=0)
    moment -= over_all_nodes(np.cross(gap_mid, mu_c)) + np.cross(gap, joint_force)
    tolerance = 2e-14  # a hundred terms of order one
    assert abs(force - 0.5 * DT * (ends[1].linear - ends[0].linear))[axis] <= tolerance
    assert abs(moment - 0.5 * DT * (ends[1].angular - ends[0].angular))[axis] <= tolerance


def test_guess_extrapolates_all_coordinates_and_keeps_the_forces(machine):
    step, state = begun(loaded(machine))
    guesses = []
    for extrapolate, factor in ((True, DT), (False, 0.0)):
        step.guess(extrapolate)
        guesses.append((extrapolate, factor, step.x.copy(), rigid_part(step, step.x)))
    for extrapolate, factor, x, (dq, dT, mu, nu, _) in guesses:
        (du,), (mu_c,), _ = step.split(x)
        P = mean_turns(state.q, state.q_dot, factor)
        of_hub, one = P[1], np.eye(3)
        v, held = (y.array_r.reshape(-1, 3) for y in (state.v[0], state.coupling[0]))
        close = partial(np.allclose, rtol=0, atol=8 * EPS * np.max(np.abs(held), initial=1.0))
        assert np.max(np.abs(of_hub - one)) > 1e-4 or not extrapolate
        assert close(du.array_r, factor * (v @ of_hub.T).ravel())
        assert close(mu_c.array_r, HALF_DT2 * (held @ (2.0 * of_hub - one).T).ravel())
        rates = state.q_dot.reshape(-1, 4, 3)
        assert close(dq, factor * np.einsum("bij,bkj->bki", P, rates).ravel())
        assert np.allclose(dT, factor * state.joint_rates, rtol=2 * EPS, atol=0)
        forces = np.concatenate([mu, nu])
        assert np.allclose(forces, HALF_DT2 * state.multipliers, rtol=4 * EPS, atol=0)


def test_finish_writes_the_state_that_belongs_to_the_unknowns(machine):
    step, state = begun(loaded(machine))
    out = step.system.initial_state()
    step.finish(out)
    (du,), (mu_c,), _ = step.split(step.x)
    dq, dT, mu, nu, _ = rigid_part(step, step.x)
    assert out.time == T0 + DT
    for found, expected in (
        (out.q, state.q + dq),
        (out.q_dot, 2 * dq / DT - state.q_dot),
        (out.joint_coordinates, state.joint_coordinates + dT),
        (out.joint_rates, dT / DT),
        (out.multipliers, np.concatenate([mu, nu]) / HALF_DT2),
        (out.u[0].array_r, state.u[0].array_r + du.array_r),
        (out.v[0].array_r, 2 * du.array_r / DT - state.v[0].array_r),
        (out.coupling[0].array_r, mu_c.array_r / HALF_DT2),
    ):
        assert np.allclose(found, expected, rtol=1e-15, atol=1e-14)  # two or three operations


def test_work_of_a_step_is_torque_at_its_middle_times_increment_of_the_angle(machine):
    step, state = begun(loaded(machine))
    works, dissipated = step.finish(state.copy())
    yaw, rotor = rigid_part(step, step.x).dT
    middle = T0 + DT / 2
    expected = {
        "torque on rotor": Hat(5.0)(middle) * rotor,
        "torque on yaw": Hat(-2.0)(middle) * yaw,
    }
    found = dict(zip(step.system.work_names, works, strict=True))
    assert found == pytest.approx({"gravity": 0.0, **expected}, rel=1e-14)
    assert dissipated.size == 0


@pytest.mark.parallel
def test_a_step_with_guess_beyond_a_quarter_turn_is_not_accepted_on_any_rank(comm, machine):
    step = EnergyMomentumStep(loaded(machine))
    step.start_step(step.system.initial_state(), DT)
    step.x.set(0.0)
    answers = [comm.allgather(step.is_accepted())]
    if comm.rank == 0:
        step.system.rigid_model.split(step.split(step.x)[2].array).dT[1] = 1.6
    answers.append(comm.allgather(step.is_accepted()))
    assert answers == [[True] * comm.size, [False] * comm.size]


def test_nothing_but_finish_writes_to_a_state(machine):
    system = loaded(machine)
    step, state = begun(system)

    def values():
        arrays = (
            state.q,
            state.q_dot,
            state.joint_coordinates,
            state.joint_rates,
            state.multipliers,
        )
        fields = (v.array_r for f in (state.u, state.v, state.coupling) for v in f)
        return [state.time, *(np.copy(a) for a in (*arrays, *fields))]

    before = values()
    step.guess(True)
    residual_at(step, step.x)
    step.tangent(step.x)
    step.finish(system.initial_state())
    assert all(np.array_equal(a, b) for a, b in zip(before, values(), strict=True))


def test_a_step_forgets_the_previous_one(machine):
    system = loaded(machine)
    step, state = begun(system)
    expected = residual_at(step, step.x)
    used = EnergyMomentumStep(system)
    used.start_step(wild_state(system, seed=5), 3 * DT)
    residual_at(used, step.x)
    used.tangent(step.x)
    used.start_step(state, DT)
    found = residual_at(used, step.x)
    found.axpy(-1.0, expected)
    assert found.norm() == 0.0


@pytest.mark.parallel
def test_relative_residuals_are_the_same_on_all_ranks_and_of_order_one_far_away(comm, machine):
    step, _ = begun(loaded(machine))
    R = residual_at(step, step.x)
    both = [step.relative_residuals(R, beyond) for beyond in (False, True)]
    assert all(np.array_equal(both, other) for other in comm.allgather(both))
    relative, beyond_round_off = both
    assert relative.shape == beyond_round_off.shape == (6,)
    assert np.allclose(beyond_round_off, relative, rtol=1e-9, atol=0)
    assert np.all(relative > 0.01)
    assert np.all(relative < 10.0)
    R.set(0.0)
    assert np.array_equal(step.relative_residuals(R), np.zeros(6))


@pytest.mark.parametrize("unit", [1e-8, 1e8])
def test_relative_residuals_do_not_depend_on_the_unit_of_mass(machine, unit):
    """An absolute tolerance would be too tight in one unit and too loose in another."""
    found = []
    for factor in (1.0, unit):
        m = machine(spin=2.0, unit=factor)
        torque = JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0 * factor))
        step = EnergyMomentumStep(m.system(Gravity(), torque))
        step.start_step(wild_state(step.system), DT)
        x = wild_unknowns(step)
        _, (mu_c,), r = step.split(x)
        mu_c.scale(factor)
        if r.getLocalSize():
            r.array[26:] *= factor  # multipliers are forces
        found.append(step.relative_residuals(residual_at(step, x)))
    assert np.allclose(*found, rtol=1e-9, atol=0)


@pytest.mark.parametrize("block", range(6))
def test_each_block_of_the_residual_is_measured_by_itself(machine, block):
    step, _ = begun(loaded(machine))
    R = residual_at(step, step.x)
    before = step.relative_residuals(R)
    (R_u,), (R_c,), R_r = step.split(R)
    target = {0: R_u, 1: R_c}.get(block)
    if target is not None:
        target.scale(2.0)
    elif R_r.getLocalSize():
        step.system.rigid_model.split(R_r.array)[block - 2][:] *= 2.0
    after = step.relative_residuals(R)
    expected = np.where(np.arange(6) == block, 2.0, 1.0) * before
    assert np.allclose(after, expected, rtol=1e-14, atol=0)


def test_torque_and_gravity_are_taken_at_the_middle_of_the_step(machine):
    times = []

    class Watch:
        def add_to(self, forces, time):
            times.append(time)

    system = machine().system(Watch())
    state = system.initial_state()
    state.time = T0
    times.clear()
    EnergyMomentumStep(system).start_step(state, DT)
    # rank 0 evaluates code of a user for all
    assert times == ([T0 + 0.5 * DT] if system.comm.rank == 0 else [])
