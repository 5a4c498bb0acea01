"""Claims about the step of a reduced body: that of the full body in the motions of its basis."""

import numpy as np
import pytest
from reduced_beams import COMM, TAU, beam, clamped, clamped_basis, free_basis
from scipy import sparse

from turbine_fenicsx import EnergyMomentum, NodeForce, RayleighDamping, ReducedBody
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.kept_slopes import LASTING, KeptSlopes
from turbine_fenicsx.time_stepping.reduced_step import ReducedStep

DT, T0, CHI = 0.02, 0.3, 0.2
GRAVITY = np.array([0.4, -9.81, 1.0])
EXACT, SINGLE = 1e-12, 1e-6
LOSSES = ["none", "chi", "rayleigh", "viscous"]


def vector(model, values):
    found = model.new_vector()
    found.array[:] = np.ravel(values)[: 3 * model.n_owned]
    return found


class Pair:
    """A free reduced body and the full one, in the same step far from any solution."""

    def __init__(self, losses):
        law = "viscous" if losses == "viscous" else "svk"
        full_body = beam(law)
        self.basis = clamped_basis(law=law)
        body = ReducedBody("reduced", full_body, self.basis)
        dampings = [None, None]
        if losses == "rayleigh":
            dampings = [RayleighDamping("d", b, stiffness=TAU) for b in (body, full_body)]
        chi = CHI if losses == "chi" else 0.0
        # the end of an edge, where there is a node
        forces = [
            NodeForce("f", b, point=(0.1, 0.15, 4.0), force=(1.0, 2.0, -3.0), function=np.cos)
            for b in (body, full_body)
        ]
        self.model = ReducedModel(body, forces[:1], dampings[0], ())
        self.full = FlexibleModel(full_body, forces[1:], dampings[1])
        self.step = ReducedStep(self.model, chi)
        self.full_step = FlexibleStep(self.full, None, chi)
        rng, n = np.random.default_rng(2), self.model.size_global
        R = rotation_about((1.0, 2.0, 3.0), 1.1)
        self.z = self.basis.vectors
        u = self.z @ R.T + 0.03 * rng.standard_normal((n, 3)) - self.z
        v, self.du = rng.standard_normal((n, 3)), 0.02 * rng.standard_normal((n, 3))
        times = StepTimes.from_start(T0, DT)
        for model, step, expand in (
            (self.model, self.step, lambda x: x),
            (self.full, self.full_step, self.on_mesh),
        ):
            step.start_step(vector(model, expand(u)), vector(model, expand(v)), times, GRAVITY)

    def on_mesh(self, values):
        return self.basis.functions @ values

    def project(self, values):
        return self.basis.functions.T @ np.reshape(values, (-1, 3))


@pytest.fixture(params=LOSSES)
def pair(request):
    return Pair(request.param)


def test_the_residual_is_a_projection_of_that_of_the_full_body(pair):
    R, of_full = pair.model.new_vector(), pair.full.new_vector()
    pair.step.residual(vector(pair.model, pair.du), R)
    pair.full_step.residual(vector(pair.full, pair.on_mesh(pair.du)), of_full)
    wanted = pair.project(of_full.array_r)
    largest = np.max(np.abs(pair.basis.functions.T) @ np.abs(of_full.array_r.reshape(-1, 3)))
    assert np.max(np.abs(R.array_r.reshape(-1, 3) - wanted)) < EXACT * largest


def differentiate(pair, dc):
    z = pair.model.vectors(pair.step._u)
    kept = pair.step._linearise(np.array([z, z + pair.du]))
    return pair.step.differentiate(kept.J, kept.loaded, dc)[0]


def test_the_tangent_with_the_present_strain_is_a_projection_too(pair):
    step, strain = pair.step, pair.model.strain
    y, dy = step._middle(pair.du[None])
    A = differentiate(pair, strain.change(y, dy))
    pair.full_step.assemble_tangent(vector(pair.full, pair.on_mesh(pair.du)))
    starts, columns, entries = pair.full_step.tangent.getValuesCSR()
    P = np.kron(pair.basis.functions, np.eye(3))
    wanted = P.T @ (sparse.csr_matrix((entries, columns, starts)) @ P)
    assert np.max(np.abs(A - wanted)) < SINGLE * np.max(np.abs(wanted))


def test_the_tangent_is_the_derivative_of_the_residual(pair):
    step, strain = pair.step, pair.model.strain
    y, dy = step._middle(pair.du[None])
    A = differentiate(pair, strain.change(y, dy))
    direction = np.random.default_rng(3).standard_normal(pair.du.shape)
    ends = []
    for sign in (1.0, -1.0):
        R = pair.model.new_vector()
        step.residual(vector(pair.model, pair.du + sign * 1e-5 * direction), R)
        ends.append(R.array_r.copy())
    slope = (ends[0] - ends[1]) / 2e-5
    assert np.max(np.abs(A @ direction.ravel() - slope)) < 1e-6 * np.max(np.abs(slope))


def test_losses_have_the_names_and_sizes_of_those_of_the_full_body(pair):
    step, full = pair.step, pair.full_step
    assert step.losses == full.midpoint.losses
    works, lost = step.works(vector(pair.model, pair.du))
    of_full = full.midpoint.works(vector(pair.full, pair.on_mesh(pair.du)))
    assert works == pytest.approx(of_full[0], rel=1e-10)
    assert lost == pytest.approx(of_full[1], rel=1e-9)
    assert all(x > 0.0 for x in lost)


def test_a_step_gains_as_much_strain_energy_as_its_forces_do_work(pair):
    """S y . dy = c_alg . dc, for any step."""
    step, strain = pair.step, pair.model.strain
    y, dy = step._middle(pair.du[None])
    work = np.sum(strain.stress(step._algorithmic(strain.change(y, dy))) @ y * dy)
    before, after = (np.sum(strain.strain(x) ** 2) for x in (step._y, step._y + dy))
    _, lost = step.works(vector(pair.model, pair.du))
    assert work == pytest.approx(0.5 * (after - before) + np.sum(lost), rel=1e-11)


def dense(step):
    return step.tangent.getDenseArray().copy()


def test_an_iteration_that_begins_again_has_forgotten_the_last_one(pair):
    step, du = pair.step, vector(pair.model, pair.du)
    step.start_iteration()
    step.assemble_tangent(du)
    first = dense(step)
    step.assemble_tangent(vector(pair.model, 0.5 * pair.du))
    step.assemble_tangent(du)
    assert not np.array_equal(dense(step), first)
    step.start_iteration()
    step.assemble_tangent(du)
    assert np.array_equal(dense(step), first)


def test_the_round_off_of_the_forces_is_measured(pair):
    """It is not zero, and its norm is below 1e-10 of that of the terms."""
    du = vector(pair.model, pair.du)
    assert 0.0 < pair.step.round_off < 1e-20 * pair.step.term_scale(du)


@pytest.mark.parallel
def test_directors_that_a_coupling_holds_exert_no_forces_on_each_other():
    """Their scalar products are constant: those of the parent body keep them."""
    for couplings, is_zero in ((True, True), (False, False)):
        body = ReducedBody("r", beam(), clamped_basis())
        system = clamped(body) if couplings else None
        model = system.flexible_models[0] if system else ReducedModel(body, (), None, ())
        z = body.basis.vectors.copy()
        z[1:4] *= 1.001
        c = model.strain.strain(model.strain.vectors(z[None]))
        assert (np.max(np.abs(c)) == 0.0) == is_zero


def test_an_algorithmic_stress_of_ones_own_is_refused():
    body = ReducedBody("r", beam(), free_basis())
    from turbine_fenicsx import MultibodySystem

    with pytest.raises(ValueError, match="stress is an algorithmic stress of your own, and 'r' is"):
        EnergyMomentum(MultibodySystem(COMM, [body]), stress=lambda *a: a)


def test_a_body_that_turns_takes_its_tangent_along(pair):
    """Whatever c is expected: turned Jacobians lack nothing where shapes are the same."""
    model, step = pair.model, pair.step
    step.assemble_tangent(vector(model, pair.du))
    A, u = dense(step), step._u.reshape(-1, 3)
    Q = rotation_about((-1.0, 0.5, 2.0), 0.7)
    times = StepTimes.from_start(T0, DT)
    turned = vector(model, (pair.z + u) @ Q.T - pair.z)
    step.start_step(turned, vector(model, 0.0 * u), times, GRAVITY)
    assert step.keeps_tangent
    found, lacking = step.turn_tangent(vector(model, pair.du @ Q.T))
    assert np.allclose(found, Q, rtol=0.0, atol=1e-12)
    forces = model.new_vector()
    step.residual(vector(model, pair.du @ Q.T), forces)
    assert np.max(np.abs(lacking)) < SINGLE * np.max(np.abs(forces.array_r))
    step._history = type(step._history)()  # so that the same strain is expected
    step.start_step(turned, vector(model, 0.0 * u), times, GRAVITY)
    step.assemble_tangent(vector(model, pair.du @ Q.T))
    of_all = np.kron(np.eye(len(pair.z)), Q)
    assert np.max(np.abs(dense(step) - of_all @ A @ of_all.T)) < SINGLE * np.max(np.abs(A))


def test_a_kept_tangent_lacks_what_walls_have_bent_since(pair):
    """A c - c_e acts with the old J, as it does in the tangent."""
    model, step = pair.model, pair.step
    step.assemble_tangent(vector(model, pair.du))
    J_m = step._kept.loaded[0]
    rng = np.random.default_rng(5)
    du = pair.du + 0.01 * rng.standard_normal(pair.du.shape)
    step.start_iteration()
    lag = step._change(du[None])[2] - step._expect(du[None])
    Q, lacking = step.turn_tangent(vector(model, du))
    assert step.turn_tangent(vector(model, du))[0] is None  # rotations last for all iterations
    of_old = ((lag @ J_m).reshape(-1, 3) @ Q[0].T).ravel()
    y, _ = step._middle(du[None])
    S = model.strain.stress(step._slope * lag)
    of_new = step._times.half_dt2 * model.strain.forces(S, y).ravel()
    assert np.max(np.abs(of_old - of_new)) > 0.01 * np.max(np.abs(of_new))
    assert np.allclose(lacking, of_old - of_new, rtol=0.0, atol=1e-5 * np.max(np.abs(of_new)))


def test_a_step_of_another_length_or_a_failure_needs_a_new_tangent(pair):
    step, zero = pair.step, vector(pair.model, 0.0 * pair.du)
    assert not step.keeps_tangent
    step.assemble_tangent(zero)
    step.start_step(zero, zero, StepTimes.from_start(T0, 0.5 * DT), GRAVITY)
    assert not step.keeps_tangent
    step.start_step(zero, zero, StepTimes.from_start(T0, DT), GRAVITY)
    assert step.keeps_tangent
    step.forget_tangent()
    assert not step.keeps_tangent


def test_slopes_of_loads_turn_with_the_body_and_serve_some_tangents():
    rng = np.random.default_rng(2)
    K, Q = rng.standard_normal((2, 6, 6)), rotation_about((1.0, 2.0, 3.0), 0.4)
    frames = np.array([rotation_about((k, 1.0, 0.0), 1.0) for k in range(2)])
    kept = KeptSlopes(DT, K, frames)
    of_all = np.kron(np.eye(2), Q)
    assert np.allclose(kept.turn(Q @ frames), of_all @ K @ of_all.T, rtol=0.0, atol=1e-14)
    assert kept.serve(DT)
    assert not kept.serve(0.5 * DT)
    assert not kept._replace(age=LASTING).serve(DT)
