"""The longest axis of a body, and where points are along and across it."""

from __future__ import annotations

import numpy as np
from scipy.special import eval_legendre

from turbine_fenicsx.foundation.types import Array

DEGREES = 6
"""Number of polynomials along the axis, from the constant on."""


class LongAxis:
    """Coordinates along the longest axis of inertia, and arms from the line of the centres.

    Args:
        positions: X of the nodes, shape (N, 3) [m].
        masses: Masses of the nodes, shape (N,) [kg].
        start: A point at the end where the axis starts, shape (3,) [m].

    Attributes:
        axes: Axes of inertia as columns, the long one last, shape (3, 3).
        length: Extent of the nodes along it [m].
    """

    def __init__(self, positions: Array, masses: Array, start: Array) -> None:
        self._centre = masses @ positions / masses.sum()
        arms = positions - self._centre
        self.axes: Array = np.linalg.eigh((arms * masses[:, None]).T @ arms)[1]
        if (start - self._centre) @ self.axes[:, 2] > 0.0:
            self.axes[:, 2] *= -1.0
        across = self.axes[:, 1]
        across *= np.sign(across[np.argmax(np.abs(across))])  # not by round-off, on any ranks
        self.axes[:, 0] = np.cross(across, self.axes[:, 2])
        along = arms @ self.axes[:, 2]
        self._half = float(np.max(np.abs(along)))
        self._low, self.length = float(np.min(along)), float(np.ptp(along))
        root = np.sqrt(np.abs(masses))[:, None]
        across, P = arms @ self.axes[:, :2], self.polynomials(positions)
        self._line = np.linalg.lstsq(root * P, root * across, rcond=None)[0]

    def polynomials(self, points: Array) -> Array:
        """Legendre polynomials along the axis, shape (n, DEGREES)."""
        s = (points - self._centre) @ self.axes[:, 2] / self._half
        return np.column_stack([eval_legendre(degree, s) for degree in range(DEGREES)])

    def span(self, points: Array) -> Array:
        """Places along the axis, 0 where it starts and 1 at the other end, shape (n,)."""
        s = ((points - self._centre) @ self.axes[:, 2] - self._low) / self.length
        return np.asarray(s)

    def arms(self, points: Array) -> Array:
        """Distances from the line of the centres, across the axis, shape (n, 3) [m]."""
        across = (points - self._centre) @ self.axes[:, :2]
        found: Array = (across - self.polynomials(points) @ self._line) @ self.axes[:, :2].T
        return found
