"""The rigid turbine in five angles: Newton and Euler with inertia tensors, for an ODE solver.

It shares no code with the package: no directors as unknowns, no constraints, no multipliers.
"""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

E1, E2, E3 = np.eye(3)
HUB_DISTANCE = 5.0
ARMS = (27.0 + 4.5 / np.sqrt(3.0), 29.25, 27.0 + 4.5 / np.sqrt(3.0))
AZIMUTHS = np.radians([-120.0, 0.0, 120.0])
SIGNS = (1.0, -1.0, 1.0)
# The paper's Table 1: mass [kg] and Euler values about d1, d2, d3 [kg m^2]
NACELLE = (200e3, (600e3, 600e3, 600e3))
HUB = (61e3, (102.94e3, 102.94e3, 81.33e3))
BLADE = (16.5e3, (183.5e3, 1449.5e3, 18.9e3))


def rotation(axis, angle):
    """Rodrigues' formula; the angle may be complex."""
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def chain(angles):
    """For each body: mass, inertia tensor in space, and the two Jacobians of its velocities."""
    yaw, rotor, *pitch = angles
    R1 = rotation(-E2, yaw)
    R2 = R1 @ rotation(E3, rotor)
    centre = -HUB_DISTANCE * R1 @ E3
    zero = np.zeros(3)
    bodies = [(NACELLE, R1, zero, [(0, -E2, zero)])]
    bearings = [(0, -E2, zero), (1, R1 @ E3, centre)]
    bodies.append((HUB, R2, centre, bearings))
    for k in range(3):
        span = rotation(E3, AZIMUTHS[k]) @ E2
        R = R2 @ rotation(SIGNS[k] * span, pitch[k]) @ rotation(E3, AZIMUTHS[k])
        pitch_bearing = (2 + k, SIGNS[k] * R2 @ span, centre)
        bodies.append((BLADE, R, centre + ARMS[k] * R2 @ span, [*bearings, pitch_bearing]))
    for (mass, euler), R, position, joints in bodies:
        inertia = R @ np.diag(np.sum(euler) - np.asarray(euler)) @ R.T
        turning, moving = np.zeros((2, 3, 5), dtype=R.dtype)
        for j, axis, point in joints:
            turning[:, j] = axis
            moving[:, j] = np.cross(axis, position - point)
        yield mass, inertia, turning, moving


def accelerations(angles, rates, torques):
    """Second derivatives of the five angles."""
    matrix, force = np.zeros((5, 5)), np.array(torques, dtype=float)
    h = 1e-30  # the step of a complex derivative, without round-off
    ahead = chain(angles + 1j * h * rates)
    for (mass, inertia, turning, moving), (*_, turning_h, moving_h) in zip(
        chain(angles), ahead, strict=True
    ):
        spin = turning @ rates
        gyroscopic = np.cross(spin, inertia @ spin) + inertia @ (turning_h.imag / h @ rates)
        matrix += mass * moving.T @ moving + turning.T @ inertia @ turning
        force -= mass * moving.T @ (9.81 * E2 + moving_h.imag / h @ rates) + turning.T @ gyroscopic
    return np.linalg.solve(matrix, force)


def solve(torques, duration, end):
    """Angles at the end [rad] from rest, with hat-shaped torques of these peaks [Nm]."""

    def derivative(t, y):
        hat = max(0.0, 1.0 - abs(2.0 * t / duration - 1.0))
        return np.concatenate([y[5:], accelerations(y[:5], y[5:], hat * np.asarray(torques))])

    y, kinks = np.zeros(10), [0.0, 0.5 * duration, duration, end]
    for start, stop in pairwise(kinks):
        if stop > start:
            run = solve_ivp(derivative, (start, stop), y, method="DOP853", rtol=1e-12, atol=1e-14)
            y = run.y[:, -1]
    return y[:5]
