"""Claims about the generalised-alpha method, with forces of all kinds on all kinds of parts."""

import numpy as np
import pytest
from wild_steps import fill, wild_state, wild_unknowns

from turbine_fenicsx import (
    Gravity,
    Hat,
    JointDamper,
    JointSpring,
    JointTorque,
    KelvinVoigt,
    PointDamper,
    PointSpring,
    PrescribedMotion,
    Pressure,
    Revolute,
)
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import (
    Accelerations,
    Coefficients,
    GeneralisedAlpha,
    GeneralisedAlphaStep,
)

DT, END = 0.05, 0.4
EPS = np.finfo(float).eps


def loaded(machine, driven=False):
    """A machine of rigid and flexible, viscous parts with a force of each kind."""
    m = machine(spin=2.0)
    viscous = KelvinVoigt(m.beam.material, 2.0, 1.0)
    beam = FlexibleBody("beam", m.beam.mesh, viscous, m.beam.density)
    m.beam, m.root = beam, Coupling("root", beam, m.facets(0.5), m.hub)
    at, to = (0.5, 0.5, -1.0), (2.0, 1.0, 1.0)
    more = [
        Gravity(),
        JointSpring("spring", "yaw", 3.0),
        JointDamper("damper", "yaw", 0.3),
        PointSpring("rope", m.hub, None, first_point=at, second_point=to, stiffness=4.0),
        PointDamper("strut", m.hub, None, first_point=at, second_point=to, damping=0.4),
        Pressure("blast", beam, m.facets(1.5), 2.0, Hat(2.0)),
        PrescribedMotion("rotor", lambda t: 2.0 * t + t**2)
        if driven
        else JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0)),
    ]
    return MultibodySystem(m.comm, [*m.parts, *more])


def begun(system):
    """A step begun with arbitrary state, accelerations and unknowns."""
    step, state = GeneralisedAlphaStep(system, 0.8), wild_state(system)
    rng, n = np.random.default_rng(5), state.q.size + state.joint_coordinates.size
    values = []
    for seed in (30, 40):
        vectors = [u.duplicate() for u in state.u]
        for vector in vectors:
            fill(vector, seed, 0.5)
        values.append(np.concatenate([*(v.array for v in vectors), rng.normal(size=n)]))
    step.ends = [Accelerations(state.time, *values, np.zeros(0))]
    step.start_step(state, DT)
    wild_unknowns(step).copy(step.x)
    return step, state


def advance(stepper, dt, end=END):
    """The state at the end, from rest of the model's initial state."""
    state = stepper.system.initial_state()
    spare = state.copy()
    for _ in range(round(end / dt)):
        stepper.advance(state, dt, spare)
        state, spare = spare, state
    return state


def unknowns(state):
    """Positions, joint coordinates and multipliers of a state, and the displacements."""
    return state.q, state.joint_coordinates, state.multipliers, *(u.array.copy() for u in state.u)


def test_coefficients_are_those_of_chung_and_hulbert():
    c = Coefficients.of(0.5)
    assert c == pytest.approx((0.0, 1 / 3, 0.25 * (1 + 1 / 3) ** 2, 0.5 + 1 / 3))
    for rho in (0.0, 0.3, 0.9):
        c = Coefficients.of(rho)
        assert c.gamma == pytest.approx(0.5 - c.alpha_m + c.alpha_f)  # second order
        assert c.alpha_m < c.alpha_f < 0.5  # stable


@pytest.mark.parallel
def test_tangent_agrees_with_finite_differences_of_the_residual(machine):
    step, _ = begun(loaded(machine))
    step.tangent(step.x)
    direction, h = wild_unknowns(step, seed=20, sizes=(1.0, 1.0, 1.0)), 1e-6
    exact = step.new_nested_vector()
    step.tangent_matrix.mult(direction, exact)
    ends = []
    for sign in (1, -1):
        x, R = step.x.copy(), step.new_nested_vector()
        x.axpy(sign * h, direction)
        step.residual(x, R)
        ends.append(R)
    difference = ends[0] - ends[1]
    difference.scale(0.5 / h)
    for computed, expected in zip(difference.getNestSubVecs(), exact.getNestSubVecs(), strict=True):
        size = expected.norm()
        computed.axpy(-1.0, expected)
        assert size > 0.1
        assert computed.norm() <= 1e-8 * size


def test_first_accelerations_fulfil_the_equations_of_motion(machine):
    """Over a very short step the motion is x + v t + a t^2/2; of the exact scheme, too."""
    system, t = loaded(machine), 1e-4
    step, state = GeneralisedAlphaStep(system, 0.8), system.initial_state()
    step.start_step(state, t)
    *bodies, rigid = step.split_flat(step.ends[0].true)
    stepper, after = EnergyMomentum(system), state.copy()
    stepper.advance(state, t, after)
    found = (after.q_dot - state.q_dot) / t
    assert np.max(np.abs(found)) > 1.0
    assert np.allclose(rigid[: state.q.size], found, rtol=0, atol=2e-2 * np.max(np.abs(found)))
    for a, v, v_0 in zip(bodies, after.v, state.v, strict=True):
        found = (v.array - v_0.array) / t
        size = system.comm.allreduce(float(np.sum(found**2))) ** 0.5
        error = system.comm.allreduce(float(np.sum((a - found) ** 2))) ** 0.5
        assert size > 1.0 and error < 2e-2 * size


@pytest.fixture(scope="module")
def exact(machine):
    """The state at the end, after so many steps of another scheme that it has no error here."""
    return advance(EnergyMomentum(loaded(machine)), END / 3200)


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.9])
def test_order_is_two_for_positions_and_joint_coordinates(machine, exact, rho):
    system, errors = loaded(machine), []
    for n in (100, 200, 400):
        state = advance(GeneralisedAlpha(system, rho), END / n)
        pairs = [(state.q, exact.q), (state.joint_coordinates, exact.joint_coordinates)]
        errors.append([np.max(np.abs(a - b)) for a, b in pairs])
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders[-1] > 1.9) and np.all(orders[-1] < 2.2)


@pytest.mark.parallel
def test_constraints_and_motions_hold_at_the_ends_of_steps(machine):
    system = loaded(machine, driven=True)
    state = advance(GeneralisedAlpha(system), 0.02)
    assert system.constraint_error(state) < 1e-13
    rotor = state.joint_coordinates[system.joint_coordinate_names.index("rotor")]
    assert rotor == pytest.approx(2.0 * state.time + state.time**2, abs=1e-12)


def test_works_and_losses_explain_the_energy_to_second_order(machine):
    system, errors = loaded(machine, driven=True), []
    for dt in (0.004, 0.002):
        stepper, state = GeneralisedAlpha(system), system.initial_state()
        spare, start, gained = state.copy(), system.balance(state).total, 0.0
        for _ in range(round(0.2 / dt)):
            report = stepper.advance(state, dt, spare)
            gained += report.work - sum(report.dissipated)
            state, spare = spare, state
        errors.append(abs(system.balance(state).total - start - gained))
    assert gained > 1.0
    assert errors[1] < 0.35 * errors[0] and errors[1] < 1e-3 * gained


@pytest.mark.parametrize("rho", [0.5, 0.8])
def test_a_step_leaves_rho_of_a_mode_that_it_cannot_follow(comm, rho):
    """A rotor on a spring with w dt = 2000 swings with an amplitude that falls by rho per step."""
    rotor = RigidBody("rotor", 1.0, (0.5, 0.5, 0.5), angular_velocity=(0.0, 0.0, 1e-4))
    spin = Revolute("spin", None, rotor, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    system = MultibodySystem(comm, [rotor, spin, JointSpring("stiff", "spin", (2000.0 / DT) ** 2)])
    stepper, state = GeneralisedAlpha(system, rho), system.initial_state()
    spare, energies = state.copy(), []
    for _ in range(40):
        stepper.advance(state, DT, spare)
        state, spare = spare, state
        energies.append(system.balance(state).total)
    assert (energies[39] / energies[19]) ** (1 / 40) == pytest.approx(rho, rel=0.1)


def test_rejected_step_changes_nothing(machine):
    system = loaded(machine)
    results = []
    for lengths in ([DT], [2 * DT, DT]):
        stepper, state = GeneralisedAlpha(system), system.initial_state()
        after, out = state.copy(), state.copy()
        stepper.advance(state, DT, after)
        for dt in lengths:
            stepper.advance(after, dt, out)
        results.append(unknowns(out))
    for a, b in zip(*results, strict=True):
        # a factor of the step that was rejected makes other iterations
        assert np.allclose(a, b, rtol=0, atol=1e-9 * max(np.max(np.abs(a), initial=0.0), 1.0))


@pytest.mark.parallel
def test_restart_is_the_run_that_was_not_interrupted_bit_for_bit(machine):
    system = loaded(machine)
    stepper, state = GeneralisedAlpha(system), system.initial_state()
    middle, after = state.copy(), state.copy()
    stepper.advance(state, DT, middle)
    data = stepper.save()
    stepper.advance(middle, DT, after)
    again, out = GeneralisedAlpha(system), state.copy()
    again.restore(data)
    again.advance(middle, DT, out)
    for a, b in zip(unknowns(after), unknowns(out), strict=True):
        assert np.array_equal(a, b)


def test_a_simulation_starts_anew_each_time(machine):
    system = loaded(machine)
    stepper = GeneralisedAlpha(system)
    runs = [Simulation(system, DT, 2 * DT, stepper=stepper).run() for _ in range(2)]
    assert np.allclose(runs[0].state.q, runs[1].state.q, rtol=0, atol=1e-12)


@pytest.mark.parametrize("rho", [-0.1, 1.0, 2.0, np.nan])
def test_spectral_radius_must_be_below_one(machine, rho):
    with pytest.raises(ModelError, match="spectral_radius"):
        GeneralisedAlpha(machine().system(), rho)
