"""Claims about the first guess of a step for what turns."""

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.time_stepping.first_guess import mean_turns


def test_the_guess_is_the_chord_of_a_steady_rotation():
    w, dt = np.array([0.3, -2.0, 1.1]), 0.2
    R0, speed = rotation_about((1, 2, 0), 0.6), np.linalg.norm(w)
    body = RigidBody("b", 1.0, (1, 2, 3), directors=R0, angular_velocity=w)
    rest = RigidBody("c", 1.0, (1, 2, 3), directors=R0)
    q = np.concatenate([body.coordinates, rest.coordinates])
    q_dot = np.concatenate([body.rates, rest.rates])
    P, one = mean_turns(q, q_dot, dt)
    assert np.array_equal(one, np.eye(3))
    R = rotation_about(w, 2.0 * np.arctan(0.5 * speed * dt))
    x = np.array([3.0, 1.0, -2.0])
    assert np.allclose(dt * P @ np.cross(w, x), (R - np.eye(3)) @ x, rtol=0, atol=1e-14)
    assert np.allclose(2.0 * P, np.eye(3) + R, rtol=0, atol=1e-15)
