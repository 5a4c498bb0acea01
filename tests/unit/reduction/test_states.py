"""Claims about load paths and the equilibria along them."""

import numpy as np
import pytest
from hollow_blade import COMM, blade, clamped

from turbine_fenicsx import BodyForce, Gravity, LoadPath, NodeForce, Ramp, equilibrium, smooth_loads
from turbine_fenicsx.reduction import static_states
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.smooth_loads import PROFILES, LineLoads
from turbine_fenicsx.reduction.static_body import StaticBody
from turbine_fenicsx.reduction.static_states import find_states
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.nodal_forces import find_nodal_values
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel


@pytest.fixture(scope="module")
def positions():
    return np.concatenate(COMM.allgather(FlexibleModel(blade()[0]).positions))


@pytest.fixture
def folder(tmp_path):
    """A folder that all ranks know."""
    return COMM.bcast(tmp_path)


def uniform(X):
    return np.broadcast_to([0.0, 5.0, 50.0], X.shape)


def path(name="up", field=uniform, times=(0.5, 1.0)):
    force = BodyForce(name, blade()[0], field=field, function=Ramp(1.0, 1.0))
    return LoadPath(name, [force], times)


def states(paths):
    return find_states(clamped(), blade()[0], paths)


def test_states_are_equilibria_under_the_loads_of_their_times(positions):
    (found,) = states([path()])
    assert np.array_equal(found.times, [0.5, 1.0]) and not found.given_up
    body = blade()[0]
    system = MultibodySystem(COMM, [body, *clamped().couplings, *path().forces])
    for time, u in zip(found.times, found.displacements, strict=True):
        state = equilibrium(system, [0.25 * time, time])
        wanted = np.concatenate(COMM.allgather(state.u[0].array_r.reshape(-1, 3)))
        assert np.max(np.abs(wanted)) > 0.3
        assert np.max(np.abs(u - wanted)) < 1e-4 * np.max(np.abs(wanted))


def test_gravity_and_forces_on_nodes_may_be_loads(positions):
    tip = NodeForce("tip", blade()[0], point=(21.0, 0.0, 0.0), force=(0.0, 0.0, 2e3))
    (found,) = states([LoadPath("both", [tip, Gravity((0.0, 0.0, -9.81))], [1.0])])
    assert 0.1 < np.max(np.abs(found.displacements)) < 1.0


def test_a_path_that_snaps_is_given_up_after_three_halvings(positions, monkeypatch):
    reached = []

    def solve(self, time, load=None):
        reached.append(time)
        return time < 0.66

    monkeypatch.setattr(StaticBody, "solve", solve)
    (found,) = states([path(times=(0.4, 0.8))])
    assert found.given_up
    assert np.allclose(found.times, [0.4, 0.6, 0.65])
    assert len(reached) == 7
    assert static_states.HALVINGS == 3


def test_smooth_loads_bend_and_twist_by_their_size():
    """The linear response in the softer direction is the deflection that was asked for."""
    still = StaticBody(clamped(), *[blade()[0]] * 2)
    loads, size = LineLoads(still), 0.02
    push, moment = loads.find_amplitudes(PROFILES["uniform"])
    axes = loads.axis.axes
    fields = [loads.field(PROFILES["uniform"], size * push * axes[:, k], 0.0) for k in range(2)] + [
        loads.field(PROFILES["uniform"], np.zeros(3), size * moment)
    ]
    forces = [BodyForce("x", blade()[0], field=field) for field in fields]
    nodal = [find_nodal_values(still.model, force).ravel() for force in forces]
    *bent, twisted = (still.gather(u) for u in still.respond(nodal))
    largest = [np.max(np.linalg.norm(u, axis=1)) for u in bent]
    assert max(largest) == pytest.approx(size * loads.axis.length, rel=1e-9)
    assert min(largest) < 0.7 * max(largest)
    # a line load of so much: resultant over length
    total = COMM.allreduce(nodal[0].reshape(-1, 3).sum(axis=0))
    per_length = np.linalg.norm(total) / loads.axis.length
    assert per_length == pytest.approx(size * push, rel=0.05)
    arms = loads.axis.arms(still.model.positions)
    turned = COMM.allreduce(np.cross(arms, nodal[2].reshape(-1, 3)).sum(axis=0) @ axes[:, 2])
    assert turned / loads.axis.length == pytest.approx(size * moment, rel=0.1)
    X = still.gather(still.model.positions)
    tip = X[:, 0] > 20.9
    angle = np.cross(X[tip] * [0, 1, 1], twisted[tip])[:, 0].sum() / np.sum(X[tip, 1:] ** 2)
    assert abs(angle) == pytest.approx(size, rel=0.3)
    still.destroy()


def test_the_axes_do_not_depend_on_round_off(positions):
    masses, start = np.ones(len(positions)), np.array([1.0, 0.0, 0.0])
    axes = LongAxis(positions, masses, start).axes
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-12) and np.linalg.det(axes) > 0.0
    assert axes[0, 2] > 0.9
    for seed in range(8):
        noise = 1e-12 * np.random.default_rng(seed).standard_normal(positions.shape)
        order = np.random.default_rng(seed).permutation(len(positions))
        other = LongAxis((positions + noise)[order], masses, start).axes
        assert np.allclose(other, axes, atol=1e-9)


def test_unseen_loads_are_none_of_training():
    seen, unseen = (smooth_loads(clamped(), blade()[0], unseen=x) for x in (False, True))
    assert len(seen) == 16 and len(unseen) == 4
    X = FlexibleModel(blade()[0]).positions
    fields = [[p.forces[0].field(X).ravel() for p in paths] for paths in (seen, unseen)]
    for a in fields[1]:
        products = [COMM.allreduce(np.array([a @ b, a @ a, b @ b])) for b in fields[0]]
        assert max(ab / np.sqrt(aa * bb) for ab, aa, bb in products) < 0.99


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda b: LoadPath("x", 3.0), TypeError, "forces of 'x' must be a sequence, got float"),
        (lambda b: LoadPath("x", [], []), ValueError, "times of 'x' must rise from above zero"),
        (lambda b: LoadPath("x", [], [0.0, 1.0]), ValueError, "must rise from above zero, got"),
        (lambda b: LoadPath("x", [], [1.0, 0.5]), ValueError, "must rise from above zero"),
        (lambda b: smooth_loads(clamped(), b, size=0.0), ValueError, "size of smooth loads must"),
    ],
)
def test_mistakes_are_refused_in_a_sentence(make, error, words):
    with pytest.raises(error, match=words):
        make(blade()[0])
