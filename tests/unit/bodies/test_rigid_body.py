"""Claims about rigid bodies with directors; oracle: the classical mechanics of a rigid body."""

import numpy as np
import pytest

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.foundation.rotations import rotation_about

MASS, EULER = 7.0, (3.0, 5.0, 0.5)
X0, W, V = np.array([1.0, -2.0, 0.5]), np.array([0.3, -1.1, 0.8]), np.array([2.0, 0.1, -0.7])
R0 = rotation_about((1.0, 2.0, -1.0), 0.9)
ROUND_OFF = 1e-14
"""A few dozen operations on numbers of order one to ten, relative to their size."""


def body(**changes):
    data = {
        "name": "b",
        "mass": MASS,
        "euler": EULER,
        "position": X0,
        "directors": R0,
        "velocity": V,
        "angular_velocity": W,
    }
    return RigidBody(**(data | changes))


def test_coordinates_are_the_centre_and_then_the_directors():
    phi, *d = body().coordinates.reshape(4, 3)
    assert np.array_equal(phi, X0)
    for i in range(3):
        assert np.array_equal(d[i], R0[:, i])


def test_rates_are_the_velocity_and_the_turning_of_the_directors():
    b = body()
    phi_dot, *d_dot = b.rates.reshape(4, 3)
    assert np.array_equal(phi_dot, V)
    for i in range(3):
        assert np.allclose(d_dot[i], np.cross(W, R0[:, i]), rtol=0, atol=ROUND_OFF)
    h = 1e-5  # central difference of the moved body: error h^2 W^3/6 = 5e-11
    angle = np.linalg.norm(W) * h
    ends = [rotation_about(W, s * angle) @ R0 for s in (1, -1)]
    assert np.allclose(((ends[0] - ends[1]) / (2 * h)).T, d_dot, rtol=0, atol=2e-10)


def test_mass_matrix_is_diagonal_with_mass_and_euler_values():
    expected = [MASS] * 3 + [3.0] * 3 + [5.0] * 3 + [0.5] * 3
    assert np.array_equal(body().masses, expected)


def test_kinetic_energy_equals_the_classical_one():
    b = body()
    J_body = np.sum(EULER) * np.eye(3) - np.diag(EULER)
    J = R0 @ J_body @ R0.T
    energy = 0.5 * b.rates @ (b.masses * b.rates)
    assert energy == pytest.approx(0.5 * MASS * V @ V + 0.5 * W @ J @ W, rel=ROUND_OFF)


def test_angular_momentum_equals_the_classical_one():
    b = body()
    J = R0 @ (np.sum(EULER) * np.eye(3) - np.diag(EULER)) @ R0.T
    momenta = (b.masses * b.rates).reshape(4, 3)
    L = np.cross(b.coordinates.reshape(4, 3), momenta).sum(axis=0)
    assert np.allclose(L, np.cross(X0, MASS * V) + J @ W, rtol=0, atol=50 * ROUND_OFF)


def test_body_coordinates_give_the_point_back():
    points = np.random.default_rng(5).normal(size=(2, 4, 3))
    xi = body().body_coordinates(points)
    assert xi.shape == points.shape
    assert np.allclose(X0 + xi @ R0.T, points, rtol=0, atol=ROUND_OFF)
    assert np.allclose(body().body_coordinates(X0 + 2.0 * R0[:, 1]), [0, 2, 0], atol=ROUND_OFF)


def moved(b, R, shift):
    """Coordinates of the body after a superposed rotation and translation."""
    q = b.coordinates.reshape(4, 3) @ R.T
    q[0] += shift
    return q.ravel()


def test_points_and_directions_of_a_frame_move_with_the_body():
    b, frame = body(), BodyFrame(body(), 4)  # second body: slots 4 to 7
    point, direction = np.array([0.3, 0.0, -4.0]), np.array([0.0, 2.0, 0.0])
    R, shift = rotation_about((0.2, 1.0, 3.0), 2.5), np.array([10.0, -3.0, 1.0])
    functions = [*frame.point(point).components(), *frame.direction(direction).components()]
    q = np.concatenate([np.full(12, np.nan), moved(b, R, shift)])
    x, n = QuadraticMap(functions, 24).value(np.nan_to_num(q)).reshape(2, 3)
    assert np.allclose(x, R @ point + shift, rtol=0, atol=5 * ROUND_OFF)
    assert np.allclose(n, R @ direction, rtol=0, atol=5 * ROUND_OFF)


def test_the_ground_does_not_move():
    ground = BodyFrame(None)
    functions = [*ground.point((1, 2, 3)).components(), *ground.direction((4, 5, 6)).components()]
    assert all(f.linear == () and f.bilinear == () for f in functions)
    assert [f.constant for f in functions] == [1, 2, 3, 4, 5, 6]


def test_a_point_at_the_centre_of_mass_does_not_depend_on_the_directors():
    components = BodyFrame(body(), 0).point(X0).components()
    assert {i for f in components for i, _ in f.linear} == {0, 1, 2}


def test_internal_constraints_say_that_the_directors_are_orthonormal():
    b = body()
    g = QuadraticMap(BodyFrame(b, 0).internal_constraints(), 12)
    assert g.shape == (6, 12)
    assert np.max(np.abs(g.value(b.coordinates))) <= ROUND_OFF
    q = np.random.default_rng(6).normal(size=12)
    d = q.reshape(4, 3)[1:]
    C = d @ d.T
    expected = [*(np.diag(C) - 1) / 2, C[0, 1], C[0, 2], C[1, 2]]
    assert np.allclose(g.value(q), expected, rtol=0, atol=5 * ROUND_OFF)
    assert np.linalg.matrix_rank(g.jacobian(b.coordinates)) == 6


def test_internal_constraints_are_invariant_under_rigid_motions():
    g = QuadraticMap(BodyFrame(body(), 0).internal_constraints(), 12)
    q = np.random.default_rng(7).normal(size=12)  # not on the manifold
    R = rotation_about((3.0, 1.0, 1.0), 1.0)
    turned = (q.reshape(4, 3) @ R.T).ravel() + np.repeat([1.0, 0, 0, 0], 3)
    assert np.allclose(g.value(turned), g.value(q), rtol=0, atol=10 * ROUND_OFF)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan"), float("inf")])
def test_mass_must_be_positive(mass):
    with pytest.raises(ValueError, match=f"mass of rigid body 'b' must be positive, got {mass}"):
        body(mass=mass)


@pytest.mark.parametrize("euler", [(1, 1, -1e-3), (1, 0, 0), (1, 1), (1, 1, 1, 1)])
def test_euler_values_must_be_three_and_at_most_one_zero(euler):
    with pytest.raises(ValueError, match="Euler values of rigid body 'b' must be three numbers"):
        body(euler=euler)


def test_one_euler_value_may_vanish():
    assert body(euler=(1, 0, 2)).masses[6:9].tolist() == [0, 0, 0]  # a plate


@pytest.mark.parametrize(
    "directors",
    [np.eye(2), 2 * np.eye(3), np.eye(3) + 1e-3, np.eye(3)[:2], np.full((3, 3), np.nan)],
)
def test_directors_must_be_orthonormal(directors):
    with pytest.raises(ValueError, match="directors of rigid body 'b' must be a rotation matrix"):
        body(directors=directors)


def test_directors_must_be_right_handed():
    with pytest.raises(ValueError, match="directors of rigid body 'b' must be a rotation matrix"):
        body(directors=np.diag([1.0, 1.0, -1.0]))


def test_directors_must_be_orthonormal_to_round_off():
    """Else the run starts with a constraint error that the first step turns into a kick."""
    with pytest.raises(ValueError, match="directors of rigid body 'b' must be a rotation matrix"):
        body(directors=(1 + 1e-6) * np.eye(3))


def test_euler_values_must_be_numbers():
    with pytest.raises(ValueError, match="Euler values of rigid body 'b'"):
        body(euler=(1.0, float("nan"), 1.0))
