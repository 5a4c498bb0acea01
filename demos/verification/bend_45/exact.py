"""The bend as a curved beam with shear and stretch (Reissner, Simo), a boundary value problem.

With the arc length s, position x, rotation R (its columns are the directors, d1 along the beam),
force n and moment m,

    x' = R (e1 + gamma),  R' = R skew(k0 + kappa),  n' = 0,  m' = n x x',
    R^T n = diag(EA, GA, GA) gamma,  R^T m = diag(GJ, EI, EI) kappa,

clamped at s = 0; at the tip n = F and m = 0.
"""

import numpy as np
from scipy.integrate import solve_bvp

SHEAR_FACTOR = 5.0 / 6.0
SAINT_VENANT = 0.140577  # torsion constant of the square of side 1


def tip(force, radius=100.0, angle=np.pi / 4.0, young=1e7, torsion=SAINT_VENANT):
    """Position of the tip, shape (3,), for a section of 1 x 1 and nu = 0.

    Args:
        force: Out of the plane.
        radius: Of the axis.
        angle: That it spans [rad].
        young: Young's modulus.
        torsion: Torsion constant of the section.
    """
    length, shear = radius * angle, 0.5 * young
    D_n = np.array([young, SHEAR_FACTOR * shear, SHEAR_FACTOR * shear])
    D_m = np.array([shear * torsion, young / 12.0, young / 12.0])
    k0 = np.array([0.0, 0.0, 1.0 / radius])

    def slope(s, y, part):
        F = np.array([0.0, 0.0, part * force])
        x, d, m = y[:3], y[3:12].reshape(3, 3, -1), y[12:]
        gamma = np.einsum("ica,c->ia", d, F) / D_n[:, None]
        k = k0[:, None] + np.einsum("ica,ca->ia", d, m) / D_m[:, None]
        dx = np.einsum("i...,ic...->c...", gamma + np.eye(3)[:, :1], d)
        # d_i' = (R k) x d_i
        w = np.einsum("i...,ic...->c...", k, d)
        dd = np.stack([np.cross(w, d[i], axis=0) for i in range(3)])
        dm = np.cross(F[:, None] * np.ones_like(x), dx, axis=0)
        return np.vstack([dx, dd.reshape(9, -1), dm])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])

    def ends(a, b):
        return np.concatenate([a[:12] - start, b[12:]])

    s = np.linspace(0.0, length, 41)
    c, i = np.cos(s / radius), np.sin(s / radius)
    o, e = np.zeros_like(s), np.ones_like(s)
    y = np.array([radius * i, radius * (1 - c), o, c, i, o, -i, c, o, o, o, e, o, o, o])
    for part in np.linspace(0.0, 1.0, 7)[1:]:
        solution = solve_bvp(lambda s, y, p=part: slope(s, y, p), ends, s, y, tol=1e-9)
        assert solution.success, solution.message
        s, y = solution.x, solution.y
    return y[:3, -1]
