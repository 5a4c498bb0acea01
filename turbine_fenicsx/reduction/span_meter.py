"""Displacements and twists of the sections of a body, and how far two motions of it are apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.long_axis import LongAxis

HALF_WIDTH = 0.02
"""Half of the part of the length that a section is made of."""

FEWEST = 12
"""Minimum number of nodes of a section."""


class SpanMeter:
    """Sections at some places along a body.

    Args:
        positions: X of all nodes, shape (N, 3) [m].
        masses: Masses of the nodes, positive, shape (N,) [kg].
        axis: Its long axis.
        places: Places along the axis, from 0 to 1.
    """

    def __init__(
        self, positions: Array, masses: Array, axis: LongAxis, places: Sequence[float]
    ) -> None:
        self._X, self._masses, self._along = positions, masses, axis.axes[:, 2]
        span = axis.span(positions)
        self._sections = []
        for place in places:
            distance = np.abs(span - place)
            least = np.partition(distance, FEWEST)[FEWEST] if len(span) > FEWEST else np.inf
            self._sections.append(np.flatnonzero(distance <= max(HALF_WIDTH, 1.001 * least)))

    def displacements(self, u: Array) -> Array:
        """Mean displacements of the sections, shape (places, 3) [m].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
        """
        means = [self._masses[n] @ u[n] / self._masses[n].sum() for n in self._sections]
        return np.array(means)

    def twists(self, u: Array) -> Array:
        """Angles by which the sections have turned about the axis where it is now, (places,) [rad].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
        """
        return self._angles(self._X, self._X + u, self._along)

    def twists_between(self, u: Array, other: Array) -> Array:
        """Angles about the axis from one motion to another, shape (places,) [rad].

        Args:
            u: Displacements of all nodes, shape (N, 3) [m].
            other: Those of the other motion, of the same shape.
        """
        x = self._X + u
        turned = [self._turn(self._X, x, nodes) @ self._along for nodes in self._sections]
        return self._angles(x, self._X + other, turned)

    def _angles(self, x: Array, y: Array, axes: Array | Sequence[Array]) -> Array:
        """Turns of the sections from x to y about axes."""
        axes = np.broadcast_to(axes, (len(self._sections), 3))
        found = []
        for nodes, axis in zip(self._sections, axes, strict=True):
            *v, w = Rotation.from_matrix(self._turn(x, y, nodes)).as_quat()
            angle = 2.0 * np.arctan2(v @ axis, w)
            found.append((angle + np.pi) % (2.0 * np.pi) - np.pi)
        return np.array(found)

    def _turn(self, x: Array, y: Array, nodes: IntArray) -> Array:
        """The rotation of a section that is nearest to its motion from x to y."""
        m = self._masses[nodes, None]
        a, b = (p[nodes] - (m * p[nodes]).sum(axis=0) / m.sum() for p in (x, y))
        return nearest_rotation(b.T @ (m * a))
