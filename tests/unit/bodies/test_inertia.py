"""Claims about rigid bodies given by their tensor of inertia; oracle: their Euler values."""

import numpy as np
import pytest

from turbine_fenicsx import ModelError, RigidBody
from turbine_fenicsx.foundation.rotations import rotation_about

EULER = np.array([3.0, 5.0, 0.5])
MOMENTS = EULER.sum() - EULER
R = rotation_about((1.0, 2.0, -1.0), 0.9)
OTHER = rotation_about((0.3, -1.0, 2.0), 2.1)
X, V, W = (1.0, -2.0, 0.5), (2.0, 0.1, -0.7), (0.3, -1.1, 0.8)
ROUND_OFF = 1e-14
"""A few dozen operations on numbers of order one to ten."""


def euler_tensor(body):
    """sum E_i d_i x d_i in space [kg m^2], which does not depend on the choice of directors."""
    d = np.asarray(body.directors)
    return d @ np.diag(body.euler) @ d.T


def test_principal_moments_give_the_body_with_their_euler_values():
    body = RigidBody.from_inertia(
        "b", 7.0, MOMENTS, position=X, axes=R, velocity=V, angular_velocity=W
    )
    same = RigidBody("b", 7.0, EULER, position=X, directors=R, velocity=V, angular_velocity=W)
    assert np.allclose(body.masses, same.masses, rtol=ROUND_OFF, atol=0.0)
    assert np.array_equal(body.coordinates, same.coordinates)
    assert np.array_equal(body.rates, same.rates)


def test_a_diagonal_tensor_keeps_the_axes_and_their_order():
    body = RigidBody.from_inertia("b", 7.0, np.diag(MOMENTS), axes=R)
    assert np.array_equal(body.directors, R)
    assert np.allclose(body.euler, EULER, rtol=ROUND_OFF, atol=0.0)


@pytest.mark.parametrize("axes", [None, OTHER], ids=["inertial", "rotated"])
def test_a_tensor_in_any_axes_gives_the_same_body(axes):
    Q = np.eye(3) if axes is None else axes
    J = Q.T @ R @ np.diag(MOMENTS) @ R.T @ Q
    body = RigidBody.from_inertia(
        "b", 7.0, J, position=X, axes=axes, velocity=V, angular_velocity=W
    )
    same = RigidBody("b", 7.0, EULER, position=X, directors=R, velocity=V, angular_velocity=W)
    assert np.allclose(euler_tensor(body), euler_tensor(same), rtol=0.0, atol=10 * ROUND_OFF)
    energies = [b.rates @ (b.masses * b.rates) for b in (body, same)]
    assert energies[0] == pytest.approx(energies[1], rel=10 * ROUND_OFF)


def test_a_plate_without_thickness_is_a_body_whatever_its_axes():
    J = R @ np.diag([1.0, 2.0, 3.0]) @ R.T
    body = RigidBody.from_inertia("plate", 1.0, J)
    assert sorted(body.euler) == pytest.approx([0.0, 1.0, 2.0], abs=10 * ROUND_OFF)
    assert min(body.euler) >= 0.0


@pytest.mark.parametrize(
    ("inertia", "sentence"),
    [
        ((1.0, 1.0, 3.0), "may be larger than the sum of the other two, got 1, 1, 3 kg m"),
        (R @ np.diag((1.0, 1.0, 3.0)) @ R.T, "than the sum of the other two, got 1, 1, 3 kg m"),
        (np.eye(3) + np.eye(3, k=1), r"inertia of rigid body 'b' must be symmetric, got \[\[1"),
        ((1.0, 1.0, 0.0), "principal moments of inertia of rigid body 'b' must be positive, got"),
        ((1.0, 1.0, -1.0), "must be positive, got 1, 1, -1 kg m"),
        (5.0, r"must be three principal moments, or a tensor of shape \(3, 3\), got 5.0"),
        ([[1.0], [1.0, 2.0]], "must be three principal moments, or a tensor"),
        (np.eye(4), r"tensor of shape \(3, 3\), got an array of shape \(4, 4\)"),
        ((1.0, np.nan, 1.0), "must be three principal moments"),
    ],
)
def test_what_is_no_tensor_of_inertia_is_refused_with_the_reason(inertia, sentence):
    with pytest.raises(ModelError, match=sentence):
        RigidBody.from_inertia("b", 1.0, inertia)


def test_axes_must_be_a_rotation():
    with pytest.raises(ModelError, match="axes of rigid body 'b' must be a rotation matrix"):
        RigidBody.from_inertia("b", 1.0, MOMENTS, axes=-np.eye(3))
