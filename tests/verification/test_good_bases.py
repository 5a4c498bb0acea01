"""Claims about bases of a small hollow blade: how good they are, and what `judge` says of them."""

import re
from dataclasses import replace

import numpy as np
import pytest
from dolfinx import mesh
from hollow_blade import COMM, basis, blade, clamped

from turbine_fenicsx import (
    BodyForce,
    Coupling,
    EnergyMomentum,
    LoadPath,
    MultibodySystem,
    PrescribedMotion,
    Ramp,
    ReducedBody,
    Revolute,
    RigidBody,
    damped_modes,
    judge,
    reduce_body,
    smooth_loads,
    turning_modes,
)
from turbine_fenicsx.reduction.judge import ReducedStates


@pytest.fixture(scope="module")
def verdict():
    return judge(clamped(), blade()[0], basis(), count=4)


def test_a_good_basis_gets_no_warning(verdict):
    assert verdict.warnings == []
    assert "warning" not in str(verdict)


def test_frequencies_are_those_of_the_full_body_at_rest_and_turning(verdict):
    at_rest = verdict.frequencies
    assert at_rest[1] == pytest.approx(at_rest[0], rel=1e-7)
    full = find_turning_frequencies(blade()[0])
    assert full[0] > 1.02 * at_rest[0, 0]  # stiffened by the rotation
    reduced = find_turning_frequencies(ReducedBody("reduced", blade()[0], basis()))
    assert reduced == pytest.approx(full, rel=1e-4)


def find_turning_frequencies(body):
    """Frequencies of a blade on a hub that turns with 3 rad/s [Hz]."""
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0))
    axle = Revolute("axle", None, hub, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    drive = PrescribedMotion("axle", lambda t: 3.0 * t)
    parts = [hub, axle, drive, body, Coupling("root", body, blade()[1], hub)]
    found = turning_modes(MultibodySystem(COMM, parts), "axle", 3.0, 4)
    return [mode.frequency for mode in found.modes]


@pytest.mark.parallel
def test_unseen_states_are_found_to_a_percent_and_a_tenth_of_a_degree(verdict):
    assert len(verdict.states) == 8
    assert max(s.tip for s in verdict.states) > 1.8
    assert max(np.abs(s.twists).max() for s in verdict.states) > 2.5
    assert verdict.tip_error < 0.01
    assert verdict.twist_error(0.7) < 0.1
    assert verdict.twist_error(0.9) < 0.1
    assert max(s.residual for s in verdict.states) < 0.1


def test_the_compliance_is_that_of_the_full_body_and_never_more(verdict):
    assert set(verdict.compliances) == {"forces across", "forces along", "twisting moments"}
    assert all(-1e-9 < error < 0.02 for error in verdict.compliances.values())


@pytest.mark.parallel
def test_nodes_of_a_basis_may_stand_in_another_order(verdict):
    """As those of a file that another number of ranks has written."""
    made = basis()
    order = np.random.default_rng(0).permutation(len(made.points))
    names = ("points", "functions", "masses", "surface_of")
    turned = replace(made, **{name: getattr(made, name)[order] for name in names})
    said = judge(clamped(), blade()[0], turned, count=1)
    for a, b in zip(said.states, verdict.states, strict=True):
        assert a.twist_errors == pytest.approx(b.twist_errors, abs=1e-5)
        assert a.residual == pytest.approx(b.residual, rel=1e-3)


def test_states_in_the_basis_halve_the_error_of_the_tip(verdict):
    """With as many functions; without states the basis is that of linear responses."""
    linear = basis(loads=())
    other = judge(clamped(), blade()[0], linear, count=4)
    assert np.array_equal([s.time for s in other.states], [s.time for s in verdict.states])
    assert verdict.tip_error < 0.5 * other.tip_error
    assert len(linear.singular_values) == 0 < len(basis().singular_values)


def test_few_strain_coordinates_are_enough():
    n = 36
    assert basis().strain_factor.shape == ((n + 3) * (n + 4) // 2, 3 * n + 6 + 25)


def test_damping_ratios_of_the_first_modes_are_those_of_the_full_body():
    full, reduced = (
        damped_modes(clamped(body), count=4).modes
        for body in (None, ReducedBody("reduced", blade()[0], basis()))
    )
    for a, b in zip(full, reduced, strict=True):
        assert b.frequency == pytest.approx(a.frequency, rel=1e-4)
        assert b.damping_ratio == pytest.approx(a.damping_ratio, rel=0.01)
        assert a.damping_ratio > 0.005


def test_the_energy_is_never_more_than_that_of_the_full_body():
    system = clamped(ReducedBody("reduced", blade()[0], basis()))
    model, full = system.flexible_models[0], clamped().flexible_models[0]
    rng = np.random.default_rng(0)
    u, moved, still = model.new_vector(), full.new_vector(), full.new_vector()
    a = np.zeros((model.size_global, 3))
    a[4:] = 0.05 * rng.standard_normal(a[4:].shape)
    u.array[:] = a.ravel()[: u.array.size]
    first = COMM.scan(full.n_owned) - full.n_owned
    moved.array[:] = model.expand(u)[0, first : first + full.n_owned].ravel()
    zero = model.new_vector()
    few = COMM.allreduce(model.integrals(u, zero)[7])
    whole = COMM.allreduce(full.integrals(moved, still)[7])
    assert 0.01 * whole < few <= whole


@pytest.mark.parallel
def test_energy_and_momenta_stay_as_exact_with_few_strain_coordinates():
    body = ReducedBody("blade", blade()[0], basis())
    hub = RigidBody("hub", 500.0, (500.0,) * 3, angular_velocity=(0.3, 0.2, 3.0))
    system = MultibodySystem(COMM, [hub, body, Coupling("root", body, blade()[1], hub)])
    stepper, now = EnergyMomentum(system), system.initial_state()
    out, before, lost = system.initial_state(), system.balance(now), 0.0
    for _ in range(100):
        lost += sum(stepper.advance(now, 0.02, out).dissipated)
        now, out = out, now
    after = system.balance(now)
    assert after.strain > 1.0 and lost > 1.0
    assert after.total + lost == pytest.approx(before.total, rel=1e-11)
    assert np.max(np.abs(after.angular - before.angular)) < 1e-11 * np.linalg.norm(before.angular)


@pytest.fixture(scope="module")
def poor():
    """A basis of few functions under a heavy load."""
    body = blade()[0]
    few = reduce_body(clamped(), body, 1, 6, loads=())
    heavy = smooth_loads(clamped(), body, size=0.3, unseen=True)[:1]
    return judge(clamped(), body, few, heavy, count=4)


@pytest.mark.parametrize(
    "words",
    [
        r"frequency 2 is wrong by [\d.]+ %: take modes = 4, or functions = 12 instead of 6",
        r"too stiff by \d+ % under smooth twisting moments: take functions = 12 instead of 6",
        r"displacement of the tip is wrong by up to \d+ %: take functions = 12 instead of 6, or",
        r"the twist at 0.7 of the span is wrong by up to [\d.]+ degrees",
    ],
)
def test_a_poor_basis_is_warned_of_with_what_helps(poor, words):
    assert any(re.search(words, warning) for warning in poor.warnings), poor.warnings
    assert all(f"warning: {warning}" in str(poor) for warning in poor.warnings)


def test_a_state_that_the_reduced_body_does_not_have_is_told(monkeypatch):
    monkeypatch.setattr(ReducedStates, "_reach", lambda *_: False)
    monkeypatch.setattr(ReducedStates, "_reach_from", lambda *_: False)
    found = judge(clamped(), blade()[0], basis(), count=1)
    assert any("no equilibrium near that of the full one in 8 of 8" in w for w in found.warnings)
    assert found.tip_error == 0.0


def test_a_verdict_can_be_drawn(verdict, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "verdict.png"
    verdict.draw(path)
    assert path.stat().st_size > 20_000
    replace(verdict, states=(), singular_values=np.zeros(0)).draw(path)
    assert path.stat().st_size > 5_000


def test_a_body_between_two_interfaces_learns_from_loads_with_one_of_them_free():
    """A mast with a light head: its equilibria have moved heads."""
    body, root = blade()
    top = mesh.locate_entities_boundary(body.mesh, 2, lambda X: np.isclose(X[0], 21.0))
    head = RigidBody("head", 10.0, (1.0, 1.0, 1.0), position=(21.0, 0.0, 0.0))
    ends = [Coupling("root", body, root, None), Coupling("top", body, top, head)]
    system = MultibodySystem(COMM, [body, head, *ends])
    paths = smooth_loads(system, body)[:4]
    found = reduce_body(system, body, 2, 30, loads=paths)
    said = judge(system, body, found, smooth_loads(system, body, unseen=True)[:1], count=2)
    assert said.states[-1].tip > 1.5
    assert said.tip_error < 0.01
    assert said.twist_error(0.7) < 0.1


def test_loads_that_have_no_equilibrium_are_refused():
    def pull(X):
        return np.broadcast_to([0.0, 0.0, 1e12], X.shape)

    force = BodyForce("pull", blade()[0], field=pull, function=Ramp(1.0, 1.0))
    with pytest.raises(ValueError, match="none of the loads of 'blade' has an equilibrium: reduce"):
        reduce_body(clamped(), blade()[0], 1, 6, loads=[LoadPath("pull", [force], [1.0])])


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"loads": 3}, TypeError, "loads must be a sequence of LoadPaths, got int"),
        ({"loads": [3]}, TypeError, "loads must be a sequence of LoadPaths, got list"),
        ({"strains": -1}, ValueError, "strains must be a whole number, zero or more, got -1"),
    ],
)
def test_mistakes_are_refused_in_a_sentence(options, error, words):
    with pytest.raises(error, match=words):
        reduce_body(clamped(), blade()[0], 1, 6, **options)


def test_two_paths_of_one_name_are_refused():
    paths = smooth_loads(clamped(), blade()[0], unseen=True)[:1] * 2
    with pytest.raises(ValueError, match=r"names of load paths must be unique, but .* occur more"):
        judge(clamped(), blade()[0], basis(), paths)


def test_a_free_body_has_frequencies_and_nothing_else():
    body = blade()[0]
    alone = MultibodySystem(COMM, [body])
    said = judge(alone, body, reduce_body(alone, body, 2, 12), count=2)
    assert said.frequencies[1] == pytest.approx(said.frequencies[0], rel=1e-7)
    assert said.states == () and said.compliances == {}
    assert "equilibrium" not in str(said) and "compliance" not in str(said)
    loads = [LoadPath("x", [], [1.0])]
    for use in (
        lambda: smooth_loads(alone, body),
        lambda: reduce_body(alone, body, 1, 6, loads=loads),
        lambda: judge(alone, body, basis(), loads),
    ):
        with pytest.raises(ValueError, match="loads need a coupling that holds 'blade', and there"):
            use()
