"""Claims about flexible bodies that are deformed at t = 0."""

import numpy as np
import pytest
from bricks import box, facets_at

from turbine_fenicsx import Gravity, StVenantKirchhoff
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem

LAME, DENSITY = (4e5, 3e5), 1000.0
SIZE = (1.0, 0.2, 0.2)


def beam(comm, displacement, velocity=None):
    cells = box(comm, SIZE, (4, 1, 1))
    return FlexibleBody(
        "beam", cells, StVenantKirchhoff(*LAME), DENSITY, 2, None, velocity, displacement
    )


def clamped(comm, displacement, *more):
    body = beam(comm, displacement)
    root = Coupling("root", body, facets_at(body.mesh, 0.0), None)
    return MultibodySystem(comm, [body, root, *more])


def bent(X):
    """A deflection along z that is zero with its slope at the root."""
    return np.outer(0.1 * X[:, 0] ** 2, [0.0, 0.0, 1.0])


def test_a_body_that_is_bent_at_the_start_swings_from_there_and_keeps_its_energy(comm):
    system = clamped(comm, bent)
    state = system.initial_state()
    X = system.flexible_models[0].positions
    assert np.array_equal(state.u[0].array_r.reshape(-1, 3), bent(X))
    start = system.balance(state)
    assert start.strain > 0.1 and start.kinetic == 0.0
    last = Simulation(system, 0.01, 0.1).run()
    assert last.balance.kinetic > 0.1 * start.strain
    assert abs(last.energy_error) < 1e-10 * start.strain


def test_a_homogeneous_deformation_has_the_energy_of_its_strain(comm):
    """E = (s^2 - 1)/2 along x, W = (Lambda + 2 mu) E^2/2."""
    s = 1.1
    body = beam(comm, lambda X: X * np.array([s - 1.0, 0.0, 0.0]))
    system = MultibodySystem(comm, [body])
    E = 0.5 * (s**2 - 1.0)
    exact = 0.5 * (LAME[0] + 2.0 * LAME[1]) * E**2 * np.prod(SIZE)
    found = system.balance(system.initial_state()).strain
    assert found == pytest.approx(exact, rel=1e-12)


def test_an_array_of_nodal_values_starts_where_an_equilibrium_was(comm):
    gravity = Gravity((0.0, 0.0, -1.0))
    resting = equilibrium(clamped(comm, None, gravity))
    values = resting.u[0].array_r.reshape(-1, 3).copy()
    assert comm.allreduce(np.abs(values).max(initial=0.0)) > 1e-3
    last = Simulation(clamped(comm, values, gravity), 0.01, 0.05).run()
    assert last.balance.kinetic < 1e-12 * abs(last.balance.strain)


def test_a_turned_body_moves_with_its_carrier_from_where_it_is(comm):
    """A rigid shift of the free part changes its velocity by omega x u."""
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0), angular_velocity=(0.0, 2.0, 0.0))
    body = beam(comm, bent)
    root = Coupling("root", body, facets_at(body.mesh, 0.0), hub)
    system = MultibodySystem(comm, [hub, body, root])
    X = system.flexible_models[0].positions
    expected = np.cross([0.0, 2.0, 0.0], X + bent(X))
    for state in (system.initial_state(), initial_motion(system, {})):
        rates = state.q_dot[3:].reshape(3, 3)
        velocity = state.v[0].array_r.reshape(-1, 3)
        turned = state.q_dot[:3] + (X + bent(X)) @ rates
        assert np.allclose(velocity, turned, rtol=0, atol=1e-13)
    velocity = system.initial_state().v[0].array_r.reshape(-1, 3)
    assert np.allclose(velocity, expected, rtol=0, atol=1e-13)


def test_a_displacement_that_opens_a_coupling_is_refused_with_its_gap(comm):
    words = r"displacement of 'beam' opens coupling 'root' by 0\.02 m \(allowed: \de-\d+ m\)"
    with pytest.raises(ModelError, match=words):
        clamped(comm, lambda X: np.full_like(X, 0.02))


@pytest.mark.parametrize(
    ("displacement", "error", "words"),
    [
        (lambda X: X.T[:, :1], ModelError, "displacement of 'beam' must have one row per point"),
        (np.zeros((7, 2)), ModelError, "displacement of 'beam' must have one row per point"),
        (lambda X: X + np.nan, ModelError, "displacement of 'beam' must be finite"),
        (0.1, TypeError, "must be a function of positions or an array, got float 0.1"),
    ],
)
def test_a_displacement_that_is_none_is_refused(comm, displacement, error, words):
    with pytest.raises(error, match=words):
        clamped(comm, displacement)


def test_rotation_of_all_nodes_strains_nothing(comm):
    R = rotation_about((1.0, 2.0, 0.5), 1.1)
    system = MultibodySystem(comm, [beam(comm, lambda X: X @ (R - np.eye(3)).T)])
    assert system.balance(system.initial_state()).strain < 1e-20 * LAME[0]
