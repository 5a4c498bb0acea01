"""Exact solution of a bent solid: a block becomes a sector of a ring (after Rivlin).

Points at the height Y of a block go to the radius r(Y), and sections stay plane, the angle between
them being kappa per length. With the stretches l1 = kappa r along and l2 = r' across the block, and
for a St. Venant-Kirchhoff material with nu = 0, the stresses per reference area are

    P1 = E l1 (l1^2 - 1)/2,    P2 = E l2 (l2^2 - 1)/2,    P2' = kappa P1,    P2 = 0 outside,

and the moment per depth is the integral of P1 r over Y.
"""

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq


def stretch(P):
    """The l with l (l^2 - 1)/2 = P, near one."""
    found = np.ones_like(P)
    for _ in range(20):
        found = found - (found * (found**2 - 1.0) / 2.0 - P) / (1.5 * found**2 - 0.5)
    return found


def moment(curvature):
    """Moment of a block of height and depth one and E = 1, for an angle per length."""

    def slope(Y, y):
        shift, P2 = y  # r = 1/kappa + Y + shift
        along = 1.0 + curvature * (Y + shift)
        return np.array([stretch(P2) - 1.0, curvature * along * (along**2 - 1.0) / 2.0])

    Y = np.linspace(-0.5, 0.5, 81)
    start = np.zeros((2, 81))
    solution = solve_bvp(slope, lambda a, b: np.array([a[1], b[1]]), Y, start, tol=1e-10)
    assert solution.success, solution.message
    points, weights = np.polynomial.legendre.leggauss(20)
    along = 1.0 + curvature * (0.5 * points + solution.sol(0.5 * points)[0])
    return 0.5 * weights @ (along**2 * (along**2 - 1.0) / (2.0 * curvature))


def angle(slenderness):
    """Angle by which the end turns under M = 2 pi E I / L, for a length over height [rad]."""
    exact = 2.0 * np.pi / slenderness
    found = brentq(lambda k: moment(k) - exact / 12.0, 0.8 * exact, 1.25 * exact, xtol=1e-15)
    return float(found * slenderness)
