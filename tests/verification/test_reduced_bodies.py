"""Claims about the motion of reduced bodies: they conserve, converge, and follow the full body."""

from itertools import pairwise

import numpy as np
import pytest
from reduced_beams import (
    COMM,
    DENSITY,
    SIZE,
    beam,
    clamped,
    clamped_basis,
    expand,
    facets_at,
    free_basis,
    gusts,
    march,
    on_hub,
    placements,
    pull,
    rotor,
)
from seen import Seen

from turbine_fenicsx import (
    BodyFields,
    Checkpoints,
    Coupling,
    EnergyMomentum,
    GeneralisedAlpha,
    Gravity,
    MultibodySystem,
    NodeForce,
    Point,
    Points,
    RayleighDamping,
    ReducedBody,
    Revolute,
    RigidBody,
    Simulation,
    SolverOptions,
    reduce_body,
    turning_equilibrium,
)
from turbine_fenicsx.foundation.errors import ForeignError
from turbine_fenicsx.simulation.checkpoint import save_state
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions

CONSERVED = 1e-11
steps_and_lengths = pytest.mark.parametrize(
    ("steps", "dt"),
    [(200, 0.05), *(pytest.param(2000, dt, marks=pytest.mark.slow) for dt in (0.02, 0.05))],
)


def bend(X):
    """A deflection like that of the first free mode, with sections that turn."""
    s = 2.0 * X[:, 2] / SIZE[2] - 1.0
    slope = 0.4 * s / SIZE[2]
    return np.column_stack([0.1 * s * s, 0.0 * s, -X[:, 0] * slope])


def tumbling():
    """A bent beam in free flight."""
    w, centre = np.array([0.5, 1.5, 0.3]), np.array([0.0, 0.0, 0.5 * SIZE[2]])

    def velocity(X):
        return np.cross(w, X - centre) + np.array([1.0, 0.0, -0.5])

    body = ReducedBody("beam", beam(), free_basis(), velocity=velocity, displacement=bend)
    return MultibodySystem(COMM, [body])


@steps_and_lengths
def test_a_bent_body_in_free_flight_keeps_energy_and_momenta(steps, dt):
    system = tumbling()
    state = system.initial_state()
    before = system.balance(state)
    assert before.strain > 0.01 * before.total
    state, _, _ = march(EnergyMomentum(system), state, dt, steps)
    after = system.balance(state)
    assert after.total == pytest.approx(before.total, rel=CONSERVED)
    for name in ("linear", "angular"):
        a, b = getattr(before, name), getattr(after, name)
        assert np.max(np.abs(a - b)) < CONSERVED * np.linalg.norm(a)


@pytest.mark.parallel
@steps_and_lengths
@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), None])
def test_blades_on_a_hub_keep_energy_and_momenta(steps, dt, axis):
    """On a revolute joint the moment about its axis; in free flight all of both."""
    system = on_hub([rotor(12)], axis=axis, speed=1.5, velocity=(0.0, 0.0, 0.0))
    stepper, state = EnergyMomentum(system), system.initial_state()
    if COMM.rank == 0:  # the blades do not start as their hub does
        v = state.v[0].array.reshape(3, -1, 3)
        v[:, 4:] += 0.1 * np.random.default_rng(0).standard_normal(v[:, 4:].shape) / 4.0
    before = system.balance(state)
    state, _, _ = march(stepper, state, dt, steps)
    after = system.balance(state)
    assert after.total == pytest.approx(before.total, rel=CONSERVED)
    size = np.linalg.norm(before.angular)
    gap = np.abs(after.angular - before.angular)
    assert (np.max(gap) if axis is None else gap[0]) < CONSERVED * size
    if axis is None:
        mass = 200.0 + 3.0 * DENSITY * np.prod(SIZE)
        assert np.max(np.abs(after.linear - before.linear)) < CONSERVED * mass


@pytest.mark.parametrize("losses", ["chi", "rayleigh", "viscous", "none"])
def test_the_balance_of_energy_closes_with_forces_and_losses(losses):
    law = "viscous" if losses == "viscous" else "svk"
    body = rotor(12, law=law)
    more = [RayleighDamping("damping", body, stiffness=0.01)] if losses == "rayleigh" else []
    gravity = Gravity((0.0, -9.81, 0.0))
    system = on_hub([body], *gusts(body), pull(body), gravity, *more)
    stepper = EnergyMomentum(system, numerical_dissipation=0.2 if losses == "chi" else 0.0)
    names = {
        "chi": ("numerical dissipation of blades",),
        "rayleigh": ("structural damping of blades",),
        "viscous": ("viscosity of blades",),
        "none": (),
    }
    assert stepper.dissipation_names == names[losses]
    state = system.initial_state()
    before = system.balance(state)
    state, done, reports = march(stepper, state, 0.02, 100)
    after = system.balance(state)
    largest = max(abs(after.kinetic), abs(after.potential), abs(after.strain))
    assert abs(after.total - before.total - done) < CONSERVED * largest
    lost = sum(sum(r.dissipated) for r in reports)
    assert (lost > 1e-4 * after.strain) == (losses != "none")
    assert system.constraint_error(state) < 1e-12


def swing(dt, end=1.0):
    """Motion of all nodes of a rotor from rest under the gusts."""
    body = rotor(12)
    system = on_hub([body], *gusts(body), speed=0.0)
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), dt, round(end / dt))
    return expand(system, state)


def test_steps_are_of_second_order():
    motions = [swing(dt) for dt in (0.01, 0.005, 0.0025, 0.00125)]
    errors = [np.linalg.norm(a - b) for a, b in pairwise(motions)]
    order = np.log2(errors[-2] / errors[-1])
    assert order == pytest.approx(2.0, abs=0.05)


def one_body_each(alone):
    """The end of a rotor of three bodies with one copy each, on some ranks."""
    full = beam(alone=alone)
    basis = reduce_body(clamped(full), full, 4, 12, loads=())
    bodies = [ReducedBody(f"blade {k}", full, basis, [p]) for k, p in enumerate(placements())]
    system = on_hub(bodies, *(force for k, body in enumerate(bodies) for force in gusts(body, k)))
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), 0.02, 50)
    pairs = zip(system.flexible_models, state.u, strict=True)
    return state.q, np.concatenate([model.expand(u) for model, u in pairs])


@pytest.mark.parallel
def test_three_copies_are_three_bodies_on_any_number_of_ranks():
    body = rotor(12)
    system = on_hub([body], *gusts(body))
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), 0.02, 50)
    x = expand(system, state)
    assert np.max(np.abs(x)) > 0.1
    for alone in (False, True):
        q, each = one_body_each(alone)
        assert np.max(np.abs(state.q - q)) < 1e-11
        if not alone:  # else nodes stand in another order
            assert np.max(np.abs(x - each)) < 1e-11 * np.max(np.abs(x))


@pytest.mark.parallel
def test_a_restart_continues_bit_for_bit(shared_tmp_path):
    def run(name, end, resume=False):
        body = rotor(12)
        system = on_hub([body], *gusts(body), Gravity((0.0, -9.81, 0.0)))
        checkpoints = Checkpoints(system, shared_tmp_path / name, every=0.1)
        simulation = Simulation(system, 0.02, end, checkpoints=checkpoints)
        last = simulation.resume() if resume else simulation.run()
        return [last.state.q, *(x.array_r.copy() for x in (*last.state.u, *last.state.coupling))]

    whole = run("whole", 0.4)
    run("parts", 0.2)
    parts = run("parts", 0.4, resume=True)
    assert all(np.array_equal(a, b) for a, b in zip(whole, parts, strict=True))


@pytest.mark.parallel
def test_a_checkpoint_of_several_ranks_serves_one(shared_tmp_path):
    """Most vectors stand at the origin: their positions tell nothing."""
    together = rotor(12)
    system = on_hub([together], *gusts(together))
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), 0.02, 5)
    Checkpoints(system, shared_tmp_path).write(5, 0.1, 0.1, save_state(system, state))
    apart = ReducedBody("blades", beam(alone=True), together.basis, placements())
    found = Checkpoints(on_hub([apart], *gusts(apart)), shared_tmp_path).load()
    assert np.array_equal(found.nodal["u"][0], COMM.bcast(state.u[0].array_r.reshape(-1, 3)))
    other = ReducedBody("blades", beam(), clamped_basis(12, modes=2), placements())
    with pytest.raises(ValueError, match="has changed"):
        Checkpoints(on_hub([other], *gusts(other)), shared_tmp_path).load()


def test_a_reduced_blade_follows_the_full_one_beside_it():
    """Both on one hub, opposite to each other, under forces that mirror each other."""
    hub = RigidBody("hub", 200.0, (50.0, 50.0, 50.0), angular_velocity=(1.0, 0.0, 0.0))
    full = beam()
    reduced = ReducedBody("reduced", full, clamped_basis(36), placements(2, 0.0)[1:])
    root = facets_at(full, 0.0)
    parts = [hub, Revolute("main", None, hub, (0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0)), full, reduced]
    parts += [Coupling("root", full, root, hub), Coupling("other root", reduced, root, hub)]
    parts += [Gravity((-9.81, 0.0, 0.0))]
    system = MultibodySystem(COMM, parts)
    state, models = system.initial_state(), system.flexible_models
    before = system.balance(state)
    ends = []
    for _ in range(5):
        state, _, _ = march(EnergyMomentum(system), state, 0.02, 20)
        u = models[1].expand(state.u[1])[0]
        points = models[1].body.basis.points
        sizes = COMM.allgather(models[0].n_owned)
        rows = np.arange(sum(sizes[: COMM.rank]), sum(sizes[: COMM.rank + 1]))
        own = state.u[0].array_r.reshape(-1, 3)
        turned = u[rows] * (1.0, -1.0, -1.0)  # half a turn about e1
        assert np.allclose(points[rows], models[0].positions)
        mine = [np.max(np.abs(x), initial=0.0) for x in (turned - own, own)]
        ends.append(np.max(COMM.allgather(mine), axis=0))
    gaps, sizes = np.array(ends).T
    assert np.max(sizes) > 0.3 * SIZE[2]
    assert np.max(gaps) < 0.01 * np.max(sizes)
    assert system.balance(state).total == pytest.approx(before.total, abs=1e-9 * before.kinetic)


@pytest.mark.parallel
def test_all_ranks_hear_of_a_force_that_fails():
    def fail(t):
        if t > 0.03:
            raise ZeroDivisionError("late")
        return 1.0

    body = ReducedBody("r", beam(), clamped_basis(12))
    force = NodeForce("f", body, point=(0.0, 0.0, SIZE[2]), force=(1.0, 0.0, 0.0), function=fail)
    system = clamped(body, force)
    with pytest.raises(ForeignError, match="ZeroDivisionError: late"):
        march(EnergyMomentum(system), system.initial_state(), 0.02, 5)


def test_a_step_that_fails_names_the_body_and_no_place_of_a_vector():
    body = rotor(12)
    system = on_hub([body], *gusts(body), Gravity((0.0, -9.81, 0.0)))
    stepper = EnergyMomentum(system, options=SolverOptions(max_iterations=1))
    with pytest.raises(RuntimeError, match=r"the residual is largest in blades$"):
        march(stepper, system.initial_state(), 0.05, 1)


@pytest.mark.parametrize("start", ["initial", "turning"])
def test_a_rotor_moves_in_the_same_way_wherever_it_stands(start):
    """Points are shifted and vectors are not."""
    ends = []
    for at in (np.zeros(3), np.array([2.0, -7.0, 3.0])):
        body = rotor(12, at)
        system = on_hub([body], *gusts(body), speed=1.5, at=at)
        turning = turning_equilibrium(system, "main", 1.5) if start == "turning" else None
        state = turning or system.initial_state()
        state, _, _ = march(EnergyMomentum(system), state, 0.02, 20)
        ends.append(expand(system, state))
    assert np.max(np.abs(ends[0])) > 0.1
    assert np.max(np.abs(ends[1] - ends[0])) < 1e-10 * np.max(np.abs(ends[0]))


def test_points_of_all_copies_move_as_their_nodes():
    body = rotor(12)
    system = on_hub([body], *gusts(body))
    at = (0.1, 0.15, SIZE[2])
    places = [p.position + np.asarray(p.rotation) @ at for p in placements()]
    points = Points(system, [Point(f"tip {k}", body, x) for k, x in enumerate(places)])
    state, _, _ = march(EnergyMomentum(system), system.initial_state(), 0.02, 20)
    node = np.argmin(np.linalg.norm(body.basis.points - at, axis=1))
    wanted = [body.points[:, node] + expand(system, state)[:, node]]
    wanted.append(expand(system, state, "v")[:, node])
    assert np.allclose(points.motion(state), np.stack(wanted, axis=1), rtol=0.0, atol=1e-12)
    with pytest.raises(ValueError, match="is outside flexible body 'blades', whose nearest"):
        Points(system, [Point("p", body, (9.0, 9.0, 9.0))])


@pytest.mark.parallel
def test_reactions_at_a_root_change_the_momenta_of_the_blade():
    g, dt, point = np.array([1.0, -9.81, 2.0]), 0.02, np.array([0.0, 0.0, 0.3])
    full = beam()
    body = ReducedBody("blade", full, clamped_basis(), displacement=lambda X: 0.0 * X)
    root = Coupling("root", body, facets_at(full, 0.0), None)
    system = MultibodySystem(COMM, [body, root, Gravity(g)])
    reactions, model = Reactions(system, [Reaction(root, point)]), system.flexible_models[0]

    def see(snapshot):
        u, v = snapshot.state.u[0], snapshot.state.v[0]
        x = COMM.bcast(model.positions + u.array_r.reshape(-1, 3))
        momenta = COMM.allreduce(model.integrals(u, v))[1:7]
        return reactions.at(snapshot)[0], momenta, COMM.bcast(model.nodal_mass) @ x

    seen = Seen(see)
    Simulation(system, dt, 0.2, [seen]).run()
    loads, momenta, moments = seen.columns
    F, M = loads[1:].transpose(1, 0, 2)
    p, L = momenta.reshape(-1, 2, 3).transpose(1, 0, 2)
    mx = 0.5 * (moments[1:] + moments[:-1])
    mass = DENSITY * np.prod(SIZE)
    size = mass * np.linalg.norm(g)
    assert np.max(np.abs(F)) > 0.5 * size
    assert np.allclose(mass * g - F, np.diff(p, axis=0) / dt, rtol=0.0, atol=1e-9 * size)
    turning = np.cross(mx, g) - np.cross(point, F) - M
    assert np.allclose(turning, np.diff(L, axis=0) / dt, rtol=0.0, atol=1e-9 * size)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda s, b: GeneralisedAlpha(s, 0.8), "steps of the Newmark family"),
        (lambda s, b: BodyFields(s, b), "fields"),
    ],
)
def test_what_needs_a_mesh_says_so(make, what):
    body = rotor(12)
    system = on_hub([body])
    with pytest.raises(ValueError, match=f"{what} need a body on a mesh, and 'blades' is reduced"):
        make(system, body)


def test_noise_in_the_velocities_of_stiff_modes_does_not_spoil_the_next_step():
    """Nothing damps what alternates in velocities from step to step, and it moves nothing."""
    system = on_hub([rotor()], speed=2.0)
    stepper, dt = EnergyMomentum(system, options=SolverOptions(tolerance=1e-10)), 0.05
    state, out = system.initial_state(), system.initial_state()
    for _ in range(6):
        stepper.advance(state, dt, out)
        state, out = out, state
    noise = np.random.default_rng(1).standard_normal((system.flexible_models[0].size_global, 3))
    noise.reshape(3, -1, 3)[:, :4] = 0.0  # what the hub holds
    model = system.flexible_models[0]
    guesses = []
    for size in (0.0, 0.01):
        noisy = state.copy()
        noisy.v[0].array[:] += size * noise.ravel()[: 3 * model.n_owned]
        stepper.step.start_step(noisy, dt)
        attempt, guess = stepper._list_attempts(noisy.time, dt)[0]
        stepper._start_at(attempt, guess)
        guesses.append(stepper.step.split(stepper.step.x)[0][0].array_r.copy())
    assert np.array_equal(guesses[0], guesses[1])
    if model.n_owned:
        assert np.max(np.abs(guesses[0])) > 0.01
