"""A clamped blade as a beam with 6 by 6 matrices of its sections, as windIO files list them.

The axes are those of such files: x to the suction side, y to the trailing edge, z along the span,
the origin at the root. A section stands across the reference axis, and is turned by the twist,
positive towards feather, which is against the sense of z. Its stiffness relates forces and moments
(Fx, Fy, Fz, Mx, My, Mz) to two shears, stretch, two curvatures and twist; its inertia relates
momenta to velocities. Both are about the point where it meets the axis.

Elements have two nodes. Their stiffness is the inverse of a flexibility, which is integrated along
the curved axis, so that forces at nodes bend them exactly. Their inertia goes with displacements
and rotations that are linear along the element.
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.interpolate import make_interp_spline

from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.turbine import SectionProperties

GRAVITY = 9.81  # [m/s^2]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)
POINTS, WEIGHTS = 0.5 + 0.5 * _POINTS, 0.5 * _WEIGHTS  # on [0, 1]


@dataclass(frozen=True)
class Blade:
    """What a beam is made of.

    Attributes:
        axis: x, y and z of the reference axis [m].
        twist: Twist of the sections [deg].
        sections: Their stiffness and inertia.
    """

    axis: tuple[Curve, Curve, Curve]
    twist: Curve
    sections: SectionProperties

    def frames(self, s):
        """Points of the axis, (n, 3), and axes of the sections as columns, (n, 3, 3)."""
        slope = self._slope(s)
        e_z = slope / np.linalg.norm(slope, axis=-1)[:, None]
        across = np.cross(e_z, [1.0, 0.0, 0.0])
        across /= np.linalg.norm(across, axis=-1)[:, None]
        angle = np.radians(self.twist.smooth(s))[:, None]
        e_y = np.cos(angle) * across + np.sin(angle) * np.cross(across, e_z)
        points = np.stack([curve.smooth(s) for curve in self.axis], axis=-1)
        return points, np.stack([np.cross(e_y, e_z), e_y, e_z], axis=-1)

    def cut(self, s):
        """Points, lengths per fraction, stiffness and inertia at s, along the axes of the blade."""
        points, R = self.frames(s)
        turn = np.zeros((len(s), 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = R
        own = self.sections
        K, M = (
            turn @ make_interp_spline(own.grid, values, k=1)(s) @ _T(turn)
            for values in (own.stiffness, own.inertia)
        )
        return points, np.linalg.norm(self._slope(s), axis=-1), K, M

    def _slope(self, s):
        return np.stack([curve.slope(s) for curve in self.axis], axis=-1)


@dataclass(frozen=True)
class Beam:
    """Finite elements of a blade that is clamped at its root.

    Attributes:
        nodes: Positions, shape (n + 1, 3) [m].
        stiffness: Of all nodes, shape (6 (n + 1), 6 (n + 1)).
        inertia: The same.
    """

    nodes: np.ndarray
    stiffness: np.ndarray
    inertia: np.ndarray

    @property
    def mass(self):
        """Mass [kg]."""
        return self._resultant(0)[0]

    @property
    def centre(self):
        """Centre of mass [m]."""
        x, y = self._resultant(0), self._resultant(1)
        # the moments of a unit acceleration along x are (0, m z, -m y), along y (-m z, 0, m x)
        return np.array([y[5], -x[5], x[4]]) / self.mass

    def frequencies(self, count):
        """The lowest natural frequencies and their modes.

        Returns:
            Frequencies, shape (count,) [Hz], and displacements and rotations of the nodes, shape
            (count, n + 1, 6).
        """
        free = slice(6, None)
        squares, shapes = linalg.eigh(
            self.stiffness[free, free], self.inertia[free, free], subset_by_index=(0, count - 1)
        )
        modes = np.zeros((count, len(self.nodes), 6))
        modes[:, 1:] = shapes.T.reshape(count, -1, 6)
        return np.sqrt(squares) / (2.0 * np.pi), modes

    def bend(self, force):
        """Displacements and rotations of the nodes under forces and moments on them, (n + 1, 6)."""
        u = np.zeros(force.shape)
        u[1:] = linalg.solve(self.stiffness[6:, 6:], force[1:].ravel(), assume_a="pos").reshape(
            -1, 6
        )
        return u

    def weight(self, direction):
        """Forces and moments on the nodes by gravity along x, y or z, shape (n + 1, 6)."""
        return (self.inertia @ self._translation(direction)).reshape(-1, 6) * GRAVITY

    def _translation(self, direction):
        return np.tile(np.eye(6)[direction], len(self.nodes))

    def _resultant(self, direction):
        """Force and moment about the root of a unit acceleration, shape (6,)."""
        load = (self.inertia @ self._translation(direction)).reshape(-1, 6)
        moment = np.cross(self.nodes, load[:, :3]) + load[:, 3:]
        return np.append(load[:, :3].sum(axis=0), moment.sum(axis=0))


def make_beam(blade, elements):
    """The beam with so many elements of equal fractions of the span."""
    s = np.linspace(0.0, 1.0, elements + 1)
    nodes = blade.frames(s)[0]
    flexibility, M = np.zeros((elements, 6, 6)), np.zeros((elements, 12, 12))
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        x, length, K, inertia = blade.cut(s[:-1] + point / elements)
        ds = (weight / elements * length)[:, None, None]
        # F = int T^T C^-1 T ds: the force at the end, moved to the section
        T = _lever(nodes[1:] - x)
        flexibility += ds * (_T(T) @ np.linalg.solve(K, T))
        # M = int N^T m N ds
        N = np.concatenate([(1.0 - point) * np.eye(6), point * np.eye(6)], axis=1)
        M += ds * (N.T @ inertia @ N)
    # forces at both ends that balance, [-B; 1] f
    ends = np.concatenate([-_lever(nodes[1:] - nodes[:-1]), _one(elements)], axis=1)
    K = ends @ np.linalg.solve(flexibility, _T(ends))
    return Beam(nodes, _assemble(K), _assemble(M))


def _one(n):
    return np.tile(np.eye(6), (n, 1, 1))


def _T(matrices):
    return np.swapaxes(matrices, -1, -2)


def _lever(arm):
    """Force and moment at a point, from those at another one that is ``arm`` away, (n, 6, 6)."""
    x, y, z = arm.T
    lever = _one(len(arm))
    lever[:, 3:, :3] = np.moveaxis(
        np.array([[0.0 * x, -z, y], [z, 0.0 * x, -x], [-y, x, 0.0 * x]]), 2, 0
    )
    return lever


def _assemble(matrices):
    """Matrix of all nodes from those of the elements, shape (n, 12, 12)."""
    whole = np.zeros((6 * len(matrices) + 6,) * 2)
    for k, matrix in enumerate(matrices):
        whole[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += matrix
    return whole


def blade_of_file(turbine):
    """The blade of a windIO file, a `turbine_fenicsx.windio.turbine.WindIOTurbine`."""
    shape = turbine.blade.outer_shape
    return Blade(shape.axis, shape.twist, turbine.blade_sections)
