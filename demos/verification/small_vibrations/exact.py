"""Small vibrations in closed form: frequencies in Hz."""

import numpy as np
from scipy.optimize import brentq


def clamped_beam(count, stiffness, mass, length):
    """Bending of a clamped beam of Bernoulli and Euler: cos(x) cosh(x) = -1.

    Args:
        count: Number of frequencies.
        stiffness: E I [N m^2].
        mass: Per length [kg/m].
        length: Of the beam [m].
    """
    return (roots(count) / length) ** 2 * np.sqrt(stiffness / mass) / (2.0 * np.pi)


def roots(count):
    """Of cos(x) cosh(x) = -1, near odd multiples of pi/2; divided by cosh nothing overflows."""
    brackets = [((k - 0.9) * np.pi, k * np.pi) for k in range(1, count + 1)]
    return np.array(
        [brentq(lambda x: np.cos(x) + 1.0 / np.cosh(x), *b, xtol=1e-13) for b in brackets]
    )


def clamped_shape(root, x):
    """Deflection of the mode of a root, one at the end of the beam, at x from 0 to 1."""
    factor = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))

    def shape(z):
        return np.cosh(z) - np.cos(z) - factor * (np.sinh(z) - np.sin(z))

    return shape(root * x) / shape(root)


def pendulum(mass, distance, inertia, g):
    """A body that hangs on a hinge.

    Args:
        mass: Of the body [kg].
        distance: From hinge to centre of mass [m].
        inertia: About the centre of mass and the direction of the hinge [kg m^2].
        g: Acceleration of gravity [m/s^2].
    """
    return np.sqrt(mass * g * distance / (inertia + mass * distance**2)) / (2.0 * np.pi)


def double_pendulum(length, g):
    """Two uniform rods of the same mass and length, one hanging on the other.

    With angles a from the vertical, M a'' + K a = 0 and, over m l^2, M = [[4/3, 1/2], [1/2, 1/3]],
    K = g/l diag(3/2, 1/2); the mass drops out.
    """
    M = np.array([[4.0 / 3.0, 0.5], [0.5, 1.0 / 3.0]])
    K = g / length * np.diag([1.5, 0.5])
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)) / (2.0 * np.pi)


def four_bars(windows, length, g):
    """Rods of `four_bar` that hang: theta'' = -((N+1)/2 + N)/((N+1)/3 + N) (g/l) cos(theta)."""
    N = windows
    factor = ((N + 1) / 2.0 + N) / ((N + 1) / 3.0 + N)
    return np.sqrt(factor * g / length) / (2.0 * np.pi)
