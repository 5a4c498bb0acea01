"""First guess of a step for what turns: dq = dt v_n is wrong by (w dt)^2/2 of the radius.

The midpoint rule turns a rigid body of angular velocity w by the Cayley transform R of dt w, and
from the mean of both velocities, v_n and R v_n,

    dq = dt P v_n,    P = (1 + R)/2 = (1 + h + h h^T) / (1 + |h|^2),    h = dt w/2,

with the matrix of the cross product for h. Flexible bodies take P and R = 2 P - 1 of what carries
them; the forces that couple them turn with R. A steady rotation is then guessed exactly.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array


def mean_turns(q: Array, q_dot: Array, dt: float) -> Array:
    """P of each rigid body for a step, the unit matrix where it does not turn.

    Args:
        q: Coordinates at t_n, shape (12 bodies,).
        q_dot: Their rates.
        dt: Step [s].

    Returns:
        Shape (bodies, 3, 3).
    """
    directors, rates = (x.reshape(-1, 4, 3)[:, 1:] for x in (q, q_dot))
    products = directors.transpose(0, 2, 1) @ rates
    h = 0.25 * dt * (products.transpose(0, 2, 1) - products)  # of w = sum d_i x d_i'/2
    square = 0.5 * (h * h).sum(axis=(1, 2))  # |h|^2, and h h^T = h.h + |h|^2 for the matrix h
    return np.asarray(np.eye(3) + (h + h @ h) / (1.0 + square)[:, None, None])
