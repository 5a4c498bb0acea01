"""Flap of a rotating beam by Ritz' method (Euler-Bernoulli, hub radius zero).

With the coordinate x along the beam over its length L, and time in units of sqrt(rho A L^4/EI),

    w^2 int phi^2 dx = int phi''^2 dx + Omega^2 int (1 - x^2)/2 phi'^2 dx

is stationary at the modes. The ansatz is x^2 times Legendre polynomials.
"""

import numpy as np
from numpy.polynomial import Polynomial, legendre
from scipy.linalg import eigh

N = 12
_BASE = [
    Polynomial([0.0, 0.0, 1.0])
    * Polynomial(legendre.leg2poly([0.0] * k + [1.0]))(Polynomial([-1.0, 2.0]))
    for k in range(N)
]


def flap(speed):
    """First flap frequency and its mode, a polynomial that is one at the tip."""
    points, weights = legendre.leggauss(2 * N + 4)
    x, w = 0.5 * (points + 1.0), 0.5 * weights
    phi, slope, curvature = (np.array([p.deriv(k)(x) for p in _BASE]) for k in range(3))
    K = (curvature * w) @ curvature.T
    K += speed**2 * (slope * (w * (1.0 - x**2) / 2.0)) @ slope.T
    squares, modes = eigh(K, (phi * w) @ phi.T)
    mode = sum(a * p for a, p in zip(modes[:, 0], _BASE, strict=True))
    return float(np.sqrt(squares[0])), mode / mode(1.0)
