"""Claims about rigid bodies, joints and joint coordinates as functions of a configuration."""

import numpy as np
import pytest
from rigid_models import ELEMENTS, N_Q, A, B, hinged, sliding

from turbine_fenicsx.forces.force import StepTimes

N_T, N_G = 2, 22


def test_unknowns_are_increments_then_multipliers():
    m = hinged()
    assert (m.n_q, m.n_T, m.n_constraints, m.size) == (N_Q, N_T, N_G, 50)
    r = np.arange(50.0)
    x = m.split(r)
    assert [part.size for part in x] == [N_Q, N_T, N_G, N_T, 0]
    assert np.array_equal(np.concatenate(x), r)


def test_constraints_vanish_initially():
    m = hinged()
    q = np.concatenate([A.coordinates, B.coordinates])
    assert np.max(np.abs(m.constraint_values(q, np.zeros(N_T)))) <= 1e-15
    shifted = q.copy()
    shifted[0] += 1e-3  # A off both bearings
    values = m.constraint_values(shifted, np.zeros(N_T))
    assert np.count_nonzero(np.abs(values) > 1e-4) == 2
    turned = m.constraint_values(q, np.array([0.0, 0.2]))
    assert np.flatnonzero(np.abs(turned) > 1e-15).tolist() == [N_G + 1]


# --- stiffness and constraint gradients


def anywhere(m, seed):
    """A configuration near the initial one, angles of several turns, multipliers."""
    rng = np.random.default_rng(seed)
    q = np.concatenate([A.coordinates, B.coordinates]) + 0.3 * rng.normal(size=N_Q)
    angles = rng.uniform(-7, 7, m.n_T)
    return q, angles, rng.normal(size=m.size - N_Q - m.n_T)


def slopes(function, y, h=1e-5):
    """Derivative of a function of y by central differences, a column for each entry."""
    columns = [(function(y + h * e) - function(y - h * e)) / (2 * h) for e in np.eye(y.size)]
    return np.column_stack(columns)


@pytest.mark.parametrize("make", [hinged, sliding])
@pytest.mark.parametrize("seed", range(3))
def test_stiffness_is_the_derivative_of_the_static_forces(make, seed):
    m = make()
    q, angles, multipliers = anywhere(m, seed)
    loads = np.linspace(-1.0, 1.0, N_Q + m.n_T)

    def forces(y):
        return m.static_forces(y[:N_Q], y[N_Q:], multipliers, 0.4, loads)

    found = m.stiffness(q, angles, multipliers, 0.4)
    expected = slopes(forces, np.concatenate([q, angles]))
    assert np.max(np.abs(expected)) > 1.0
    # h^2/6 times third derivatives and 1e-16/h, with terms up to 50 in size
    assert np.allclose(found, expected, rtol=0, atol=3e-8)


@pytest.mark.parametrize("make", [hinged, sliding])
@pytest.mark.parametrize("seed", range(3))
def test_constraint_jacobian_is_the_derivative_of_the_constraint_values(make, seed):
    m = make()
    q, angles, _ = anywhere(m, seed)

    def values(y):
        relations = m.S @ y[N_Q:]
        return np.concatenate([m.constraint_values(y[:N_Q], y[N_Q:]), relations])

    found = m.constraint_jacobian(q, angles)
    assert found.shape == (m.n_constraints + m.n_T + m.n_relations, N_Q + m.n_T)
    expected = slopes(values, np.concatenate([q, angles]))
    assert np.allclose(found, expected, rtol=0, atol=1e-8)


def test_stiffness_without_follower_loads_is_symmetric():
    m = hinged()
    K = m.stiffness(*anywhere(m, 5), 0.0)
    assert np.max(np.abs(K)) > 1.0
    assert np.array_equal(K, K.T)


def test_static_forces_without_multipliers_are_the_slope_of_the_energy_of_springs():
    """And dampers do not act; the follower loads are what is left, whatever the configuration."""
    m = sliding()
    q, angles, multipliers = anywhere(m, 6)
    y, n = np.concatenate([q, angles]), N_Q + m.n_T
    found = m.static_forces(q, angles, 0 * multipliers, 0.0, np.zeros(n))
    slope = slopes(lambda y: np.array([m.spring_energy(y[:N_Q], y[N_Q:])]), y)[0]
    followers = np.zeros(n)
    for e, kind in zip(m.forces, (e.kind for e in ELEMENTS), strict=True):
        if kind == "external":
            followers[e.index] += e.force(y[e.index], y[e.index], StepTimes.at_rest(0.0))[0]
    assert np.max(np.abs(slope)) > 1.0
    assert np.allclose(found, slope - followers, rtol=0, atol=1e-8)


def test_constraint_forces_are_those_of_the_static_forces():
    m = sliding()
    q, angles, multipliers = anywhere(m, 7)
    factors, gradients = m.constraint_forces(q, angles, multipliers)
    D = m.constraint_jacobian(q, angles)
    assert np.allclose(factors @ gradients, (multipliers @ D)[:N_Q], rtol=0, atol=1e-13)
