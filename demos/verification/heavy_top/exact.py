"""The heavy top by another way: Euler's equations about `O` and a unit quaternion."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


def centre_of_mass(run, tolerance=3e-14):
    """Centre of mass at the end [m], with the data of ``run``."""
    m, X, g = run.MASS, run.ARM, np.array(run.GRAVITY)
    J_O = np.diag(run.INERTIA) + m * (X @ X * np.eye(3) - np.outer(X, X))
    inverse = np.linalg.inv(J_O)

    def rates(t, y):
        p, Omega = y[:4], y[4:]  # p = (vector, scalar)
        R = Rotation.from_quat(p).as_matrix()
        p_dot = 0.5 * np.append(p[3] * Omega + np.cross(p[:3], Omega), -p[:3] @ Omega)
        torque = np.cross(X, m * R.T @ g)
        return np.concatenate([p_dot, inverse @ (torque - np.cross(Omega, J_O @ Omega))])

    start = np.concatenate([[0.0, 0.0, 0.0, 1.0], run.SPIN])
    options = {"method": "DOP853", "rtol": tolerance, "atol": tolerance}
    end = solve_ivp(rates, (0.0, run.END), start, **options).y[:, -1]
    return Rotation.from_quat(end[:4]).apply(X)
