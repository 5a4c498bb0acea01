"""The row of four-bar linkages as what it is as long as its windows stay parallel: one angle."""

import numpy as np
from scipy.integrate import solve_ivp


def tip(run, tolerance=3e-14):
    """Place (x, y) of B_0 at the end [m], with the data of ``run``."""
    N = run.WINDOWS
    a = ((N + 1) / 2.0 + N) / ((N + 1) / 3.0 + N) * run.G / run.LENGTH
    start = [0.5 * np.pi, -run.SPEED / run.LENGTH]
    options = {"method": "DOP853", "rtol": tolerance, "atol": tolerance}
    end = solve_ivp(lambda t, y: [y[1], -a * np.cos(y[0])], (0.0, run.END), start, **options)
    theta = end.y[0, -1]
    return run.LENGTH * np.array([np.cos(theta), np.sin(theta)])
