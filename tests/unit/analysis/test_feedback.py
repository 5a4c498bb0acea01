"""A controller around a rotor of one inertia, against its equations by hand."""

import numpy as np
import pytest

from turbine_fenicsx.analysis.feedback import Feedback

INERTIA, RATIO = 4e7, 97.0
BY_SPEED, BY_PITCH, BY_PITCH_RATE = -3e6, -4e7, 1e5
"""Derivatives of the torque of the wind [N m s, N m, N m s]."""


def test_a_rotor_and_its_controller_have_the_eigenvalues_of_their_equations():
    torque, gain, w = 150.0, 2e-3, 4.0
    # states: filtered speed, pitch, rate of the pitch
    A = np.array([[-1.5, 0.0, 0.0], [0.0, 0.0, 1.0], [w * w * gain, -w * w, -1.4 * w]])
    B, C = np.array([1.5, 0.0, 0.0]), np.diag([torque, 1.0, 1.0])
    # the rotation of unit modal mass is the angle times the root of the inertia
    root = np.sqrt(INERTIA)
    n = np.array([RATIO / root, 0.0])
    matrix = np.zeros((4, 4))
    matrix[:2, 2:] = np.eye(2)
    matrix[2] = [0.0, BY_PITCH / root, BY_SPEED / INERTIA, BY_PITCH_RATE / root]
    matrix[3] = [9.0, 9.0, 9.0, 9.0]  # the pitch is prescribed: its own equation is not used
    closed = Feedback({"rotor": RATIO}, {"pitch_1": 1.0}, A, B, C).close(matrix, n)
    # speed of the rotor, then the states
    by_hand = np.zeros((4, 4))
    by_hand[0] = [BY_SPEED, -RATIO * torque, BY_PITCH, BY_PITCH_RATE]
    by_hand[0] /= INERTIA
    by_hand[1:, 0] = RATIO * B
    by_hand[1:, 1:] = A
    wanted = np.sort_complex([0.0, *np.linalg.eigvals(by_hand)])  # the angle itself is free
    assert np.sort_complex(np.linalg.eigvals(closed)) == pytest.approx(wanted, abs=1e-9)
