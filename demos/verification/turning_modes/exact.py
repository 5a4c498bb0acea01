"""Frequencies of rotating beams by Ritz' method, and of a disc on a shaft in closed form."""

import numpy as np
from numpy.polynomial import Polynomial, legendre
from scipy.linalg import eigh

N = 12
_BASE = [
    Polynomial([0.0, 0.0, 1.0])
    * Polynomial(legendre.leg2poly([0.0] * k + [1.0]))(Polynomial([-1.0, 2.0]))
    for k in range(N)
]


def beam(speed):
    """First and second flap and first lag frequency of a rotating cantilever (hub radius zero).

    Units and stiffness as in `rotating_cantilever`; the centrifugal force has no such restoring
    effect in the plane of rotation, so that there the square is less by that of the speed.
    """
    points, weights = legendre.leggauss(2 * N + 4)
    x, w = 0.5 * (points + 1.0), 0.5 * weights
    phi, slope, curvature = (np.array([p.deriv(k)(x) for p in _BASE]) for k in range(3))
    K = (curvature * w) @ curvature.T
    K += speed**2 * (slope * (w * (1.0 - x**2) / 2.0)) @ slope.T
    first, second, *_ = eigh(K, (phi * w) @ phi.T, eigvals_only=True)
    return np.sqrt([first, second, first - speed**2])


def disc(speed, length, bending, shear, mass, across, polar):
    """Backward and forward whirl of a disc at the free end of a massless shaft, four frequencies.

    With the displacement w = x + i y and the slope phi,

        m w'' + k11 w + k12 phi = 0,   J phi'' - i J_p Omega phi' + k12 w + k22 phi = 0.

    Args:
        speed: Omega [rad/s].
        length: L [m].
        bending: E I [N m^2].
        shear: kappa G A [N].
        mass: m [kg].
        across: J, about a diameter [kg m^2].
        polar: J_p [kg m^2].
    """
    f = 12.0 * bending / (shear * length**2)
    k = bending / (1.0 + f)
    K = np.array([[12.0 / length**3, -6.0 / length**2], [-6.0 / length**2, (4.0 + f) / length]]) * k
    inverse = np.diag([1.0 / mass, 1.0 / across])
    gyroscopic = np.diag([0.0, -1j * polar * speed])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ gyroscopic]])
    return np.sort(np.linalg.eigvals(A).imag)
