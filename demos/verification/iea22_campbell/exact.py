"""The beam of ``iea22_blade`` on a rotor that turns.

In the turning frame, small motions u of the blade about its undeformed shape fulfil

    M u'' + 2 Omega G u' + (K + Omega^2 (K_N - M_c)) u = 0.

M and K are those of the clamped beam. The rotation acts on the masses of the nodes: with S = [n]_x
for the axis n of the rotor, G = m S and M_c = -m S^2, which acts across the axis alone. K_N is the
stiffness of a string under the centrifugal force N of what is outboard,

    K_N = N/L (1 - t t^T)    on the difference of the displacements of an element's ends.

Left out: what the centrifugal force bends at rest, inertia of sections against rotation in G and
M_c, and the stiffness that bending moments at rest give.
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg


@dataclass(frozen=True)
class TurningBeam:
    """A clamped blade on a stiff hub.

    Attributes:
        beam: The beam at rest, of ``iea22_blade/exact.py``.
        hub_radius: Distance of its root from the centre of the hub [m].
        precone: Angle of the blade out of the rotor's plane, upwind [rad].
    """

    beam: object
    hub_radius: float
    precone: float

    def frequencies(self, speed, count):
        """The lowest frequencies at a speed [rad/s], shape (count,) [Hz]."""
        M, K = self.beam.inertia[6:, 6:], self.beam.stiffness[6:, 6:]
        G, C = self._spin_matrices()
        K = K + speed**2 * (self._string() + C)[6:, 6:]
        D = 2.0 * speed * G[6:, 6:]
        n = len(K)
        # (u', u) of the linear problem of twice the size
        A = np.block([[-D, -K], [np.eye(n), np.zeros((n, n))]])
        B = linalg.block_diag(M, np.eye(n))
        s = linalg.eigvals(A, B)
        return np.sort(s.imag[s.imag > 1e-6])[:count] / (2.0 * np.pi)

    def _axis(self):
        """Axis of the rotor in the axes of the blade: x downwind, z along the span."""
        return np.array([np.cos(self.precone), 0.0, -np.sin(self.precone)])

    def _masses(self):
        """Masses of the nodes, shape (n + 1,) [kg]."""
        along = np.tile(np.eye(6)[0], len(self.beam.nodes))
        return (self.beam.inertia @ along)[::6]

    def _arms(self):
        """Positions of the nodes from the centre of the hub, across the axis, shape (n + 1, 3)."""
        axis = self._axis()
        x = self.beam.nodes + np.array([0.0, 0.0, self.hub_radius])
        return x - np.outer(x @ axis, axis)

    def _spin_matrices(self):
        """G and -M_c = m S^2, of all nodes."""
        S = np.cross(np.eye(3), -self._axis())
        G = np.zeros_like(self.beam.inertia)
        C = np.zeros_like(G)
        for k, m in enumerate(self._masses()):
            part = slice(6 * k, 6 * k + 3)
            G[part, part], C[part, part] = m * S, m * S @ S
        return G, C

    def _string(self):
        """K_N for a speed of 1 rad/s, of all nodes."""
        forces = self._masses()[:, None] * self._arms()
        outboard = np.cumsum(forces[::-1], axis=0)[::-1]
        whole = np.zeros_like(self.beam.stiffness)
        for k, edge in enumerate(np.diff(self.beam.nodes, axis=0)):
            length = np.linalg.norm(edge)
            t = edge / length
            block = (outboard[k + 1] @ t) / length * (np.eye(3) - np.outer(t, t))
            for i, j, sign in ((0, 0, 1), (0, 1, -1), (1, 0, -1), (1, 1, 1)):
                rows, columns = 6 * (k + i), 6 * (k + j)
                whole[rows : rows + 3, columns : columns + 3] += sign * block
        return whole
