"""Claims about root loads: what they are about, in which axes, and when they are known."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

POINT = np.array([0.3, 0.2, -0.7])
AXES = rotation_about((1.0, 2.0, -1.0), 0.8)
DT = 0.02
G = np.array([0.0, -9.81, 0.0])


def run(system, *functions, steps=4):
    seen = Seen(lambda snapshot: [np.copy(f(snapshot)) for f in functions])
    simulation = Simulation(system, DT, steps * DT, [seen])
    simulation.run()
    simulation.stepper.destroy()
    return seen.columns


def mean(x):
    """Means over the steps."""
    return 0.5 * (x[1:] + x[:-1])


def motion(block):
    """Function of a snapshot: sums of p, x x p and m x over all nodes of a flexible body."""
    comm = block.body.mesh.comm

    def sums(s):
        vector = block.new_vector()
        block.momentum(s.state.v[0], vector)
        p = vector.array_r.reshape(-1, 3).copy()
        vector.destroy()
        x = block.positions + s.state.u[0].array_r.reshape(-1, 3)
        per_node = [p, np.cross(x, p), block.nodal_mass[:, None] * x]
        return comm.allreduce(np.array([values.sum(axis=0) for values in per_node]))

    return sums


@pytest.fixture
def held(comm, machine):
    """The beam alone, held by the ground under its weight, and its coupling."""
    m = machine()
    root = Coupling("root", m.beam, m.facets(0.5), None)
    return MultibodySystem(comm, [m.beam, root, Gravity(tuple(G))]), root


@pytest.fixture
def carried(machine):
    """The beam on a spinning hub whose directors are not e1, e2, e3 at first, and its coupling."""
    m = machine(spin=3.0)
    return m.system(Gravity(tuple(G))), m.root


@pytest.mark.parametrize("carrier", ["held", "carried"])
def test_load_on_the_carrier_is_the_weight_less_the_change_of_momentum(request, carrier):
    """And its moment that of the weight less the change of angular momentum, about the origin."""
    system, root = request.getfixturevalue(carrier)
    (block,) = system.flexible_models
    body = root.rigid

    def point(s):
        if body is None:
            return POINT
        phi, *d = system.coordinates_of(s.state.q)[body].reshape(4, 3)
        return phi + body.body_coordinates(POINT) @ np.array(d)

    loads, r, sums = run(
        system, Reactions(system, [Reaction(root, POINT)]).at, point, motion(block)
    )
    F, M = loads[1:, 0].transpose(1, 0, 2)
    p, L, mx = sums.transpose(1, 0, 2)
    weight = system.comm.allreduce(block.nodal_mass.sum()) * G
    assert np.max(np.abs(F)) > 0.5 * np.linalg.norm(weight)
    # forces of order ten; the solver leaves 1e-12 of the terms of its equations
    assert np.allclose(weight - F, np.diff(p, axis=0) / DT, rtol=0, atol=1e-10)
    turning = np.cross(mean(mx), G) - np.cross(mean(r), F) - M
    assert np.allclose(turning, np.diff(L, axis=0) / DT, rtol=0, atol=1e-10)


def test_components_are_those_along_the_given_axes(held):
    system, root = held
    plain, turned = Reaction(root, POINT), Reaction(root, POINT, AXES)
    both = Reactions(system, [plain, turned])
    (loads,) = run(system, both.at)
    scale = np.max(np.abs(loads))
    assert scale > 1.0
    assert np.allclose(loads[:, 0] @ AXES.T, loads[:, 1], rtol=0, atol=1e-14 * scale)


def test_axes_turn_with_the_carrier_and_are_taken_half_way(machine):
    """On a hub that turns by 0.06 rad a step and whose directors are not e1, e2, e3 at first."""
    m = machine(spin=3.0)
    system = m.system()
    fixed = Reactions(system, [Reaction(m.root, (0.5, 0.0, -1.0), AXES)])
    inertial = Reactions(system, [Reaction(m.root, (0.5, 0.0, -1.0))])
    loads, plain, q = run(system, fixed.at, inertial.at, lambda s: s.state.q, steps=3)
    d0, d1 = q[:-1, 15:24].reshape(-1, 3, 3), q[1:, 15:24].reshape(-1, 3, 3)
    for k in range(3):
        w, v = np.linalg.eig(d0[k].T @ d1[k])
        R = np.real(v @ np.diag(np.sqrt(w)) @ np.linalg.inv(v))  # R R is the whole turn
        axes = AXES @ np.asarray(m.hub.directors) @ d0[k] @ R
        expected = plain[k + 1, 0] @ axes.T
        scale = np.max(np.abs(expected))
        assert np.allclose(loads[k + 1, 0], expected, rtol=0, atol=1e-13 * scale)


def test_nothing_is_known_before_the_first_step_of_each_run(held):
    system, root = held
    loads = Reactions(system, [Reaction(root, POINT)])
    for _ in range(2):
        (values,) = run(system, loads.at, steps=2)
        assert not np.any(values[0])
        assert np.all(np.any(values[1:], axis=(1, 2, 3)))


def test_every_step_must_be_seen(held):
    system, root = held
    loads = Reactions(system, [Reaction(root, POINT)])

    def every_other(s):
        return loads.at(s) if s.index % 2 == 0 else np.zeros((1, 2, 3))

    with pytest.raises(AssertionError, match="every step"):
        run(system, every_other)


def test_foreign_couplings_are_refused(held, machine):
    m = machine()
    with pytest.raises(ModelError, match="coupling 'root' is not among the parts"):
        Reactions(held[0], [Reaction(m.root, POINT)])
