"""A curved Cosserat rod under a dead force at its end, by shooting: no finite elements."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

STEPS = 8
"""Load steps, of which each starts from the moment at the root of the one before."""


def _skew(k):
    return np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])


def bend_arc(angle, radius, stiffness, force):
    """Displacement of the end of an arc in the x-z plane that starts along z and turns to x.

    Args:
        stiffness: Of shear along x and y, stretch, bending about x and y, torsion, shape (6,).
        force: At the end, shape (3,).
    """
    compliance, rest = 1.0 / np.asarray(stiffness), np.array([0.0, 1.0 / radius, 0.0])

    def slope(_, y, n):
        R, m = y[3:12].reshape(3, 3), y[12:]
        tangent = R @ (compliance[:3] * (R.T @ n) + [0.0, 0.0, 1.0])
        turn = R @ _skew(rest + compliance[3:] * (R.T @ m))
        return np.concatenate([tangent, turn.ravel(), -np.cross(tangent, n)])

    def end(m, n):
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), m])
        span = (0.0, radius * angle)
        return solve_ivp(slope, span, start, args=(n,), rtol=1e-8, atol=1e-8).y[:, -1]

    m = np.zeros(3)
    for part in np.arange(1, STEPS + 1) / STEPS:
        n = part * np.asarray(force)
        m = root(lambda m, n=n: end(m, n)[12:], m, tol=1e-6).x
    assert np.abs(end(m, n)[12:]).max() < 1e-3
    return end(m, n)[:3] - radius * np.array([1.0 - np.cos(angle), 0.0, np.sin(angle)])
