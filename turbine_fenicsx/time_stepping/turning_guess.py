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
    h = 0.25 * dt * np.cross(directors, rates).sum(axis=1)  # w = sum d_i x d_i'/2
    cross = np.cross(np.eye(3), h[:, None])  # of h: rows e_k x h
    P = np.eye(3) + cross + h[:, :, None] * h[:, None, :]
    return np.asarray(P / (1.0 + (h * h).sum(axis=1))[:, None, None])
