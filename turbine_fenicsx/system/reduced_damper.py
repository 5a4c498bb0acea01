"""Damping of a reduced body in proportion to its mass, relative to the interface that holds it.

The interface moves like a rigid frame: with its point p, its directors d_j and
J = sum_j (|d_j|^2 1 - d_j d_j^T),

    omega = J^-1 sum_j d_j x d_j',      w_k = z_k' - h_k p' - omega x (z_k - h_k p),

where h_k is one for points and zero for vectors. On the vectors act f = -alpha M w, and on those of
the interface the transpose of its motion, with F = sum_k h_k f_k and T = sum_k (z_k - h_k p) x f_k

    -F on p,      -(J^-1 T) x d_j on d_j.

Forces and moments add up to zero; the power is -alpha w.M w. See `MassDamper` for bodies on a mesh.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.rotations import skew, skew_rows
from turbine_fenicsx.foundation.types import Array


class ReducedDamper:
    """The damping of all copies of a reduced body.

    Args:
        mass: alpha M, shape (n, n) [kg/s].
        positions: Initial values of the vectors, shape (copies n, 3) [m, -].
        is_point: h of the vectors of one copy, shape (n,).
        interface: Number of the interface that holds it.
    """

    def __init__(self, mass: Array, positions: Array, is_point: Array, interface: int) -> None:
        self._M, self._h = mass, is_point
        self._Z = positions.reshape(-1, len(is_point), 3)
        self._p, self._d = 4 * interface, slice(4 * interface + 1, 4 * interface + 4)

    def add_forces(self, u: Array, v: Array, factor: float, out: Array) -> None:
        """Add the forces on the vectors times a factor.

        Args:
            u: Displacements of the vectors, shape (3 copies n,) [m, -].
            out: What the forces are added to, of the same shape.
        """
        z, out = self._place(u), out.reshape(self._Z.shape)
        arms, inverse, w = self._find_motion(z, v)
        f = -factor * (self._M @ w)
        T = _sum_moments(arms, f)
        turn = (inverse @ T[:, :, None])[:, :, 0]
        out += f
        out[:, self._p] -= self._h @ f
        out[:, self._d] -= z[:, self._d] @ skew_rows(turn).swapaxes(1, 2)

    def power(self, u: Array, v: Array) -> float:
        """Power that it takes out [W]; arguments as of `add_forces`."""
        w = self._find_motion(self._place(u), v)[2]
        return float(np.sum(w * (self._M @ w)))

    def matrix(self, u: Array) -> Array:
        """Minus the forces per rate, shape (copies, 3 n, 3 n) [N s/m], symmetric."""
        n, found, z = len(self._h), [], self._place(u)
        arms, inverse, _ = self._find_motion(z, np.zeros_like(u))
        for r, J_inverse, vectors in zip(arms, inverse, z, strict=True):
            Q = np.eye(3 * n).reshape(n, 3, n, 3)
            Q[:, :, self._p] -= self._h[:, None, None] * np.eye(3)
            for j in range(self._d.start, self._d.stop):
                turn = J_inverse @ skew(vectors[j])
                Q[:, :, j] += np.array([skew(arm) @ turn for arm in r])
            Q = Q.reshape(3 * n, 3 * n)
            found.append(Q.T @ np.kron(self._M, np.eye(3)) @ Q)
        return np.array(found).reshape(-1, 3 * n, 3 * n)

    def _place(self, u: Array) -> Array:
        """Vectors z of each copy, shape (copies, n, 3)."""
        return self._Z + u.reshape(self._Z.shape)

    def _find_motion(self, z: Array, v: Array) -> tuple[Array, Array, Array]:
        """Arms z_k - h_k p, J^-1 and w of each copy."""
        rates = v.reshape(z.shape)
        d, arms = z[:, self._d], z - self._h[:, None] * z[:, self._p, None]
        J = np.sum(d * d, axis=(1, 2))[:, None, None] * np.eye(3) - d.swapaxes(1, 2) @ d
        inverse = np.linalg.inv(J)
        spin = _sum_moments(d, rates[:, self._d])
        omega = (inverse @ spin[:, :, None])[:, :, 0]
        w = rates - self._h[:, None] * rates[:, self._p, None]
        w -= arms @ skew_rows(omega).swapaxes(1, 2)
        return arms, inverse, w


def _sum_moments(arms: Array, f: Array) -> Array:
    """Sums of arm x f over the vectors of each copy, shape (copies, 3)."""
    A = arms.swapaxes(1, 2) @ f
    return np.stack([A[:, i, j] - A[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
