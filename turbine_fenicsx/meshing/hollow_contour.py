"""Closed outlines of the sections of a hollow blade.

An outline whose trailing edge is open or sharp is closed by a narrow face: hexahedra cannot fill
a wedge of a few degrees, and real trailing edges are not sharp. Where the edge is narrower than a
small part of the outline, it is cut off where it is that wide. The coordinate b runs from 0 to 1
like the contour fraction and, where there is such a face, on from 1 to 2 across it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.hollow_shape import HollowShape

_GAP_TOLERANCE = 1e-6  # a gap of this part of the outline is open
_SHARP = np.cos(np.radians(60.0))  # an edge with a smaller angle inside is sharp
_FACE = 5e-4  # least width of the face over the length of the outline
_DEEPEST_CUT = 0.05  # contour fraction
_STEP = 1e-6  # step of one-sided derivatives in contour and span fractions


@dataclass(frozen=True)
class Contours:
    """Outlines of sections.

    Attributes:
        shape: The blade.
        s: Span fractions of the sections, shape (S,) [-].
        cut: Contour fraction cut off at either side of the trailing edge, shape (S,) [-].
        closed: Whether there is no face.
    """

    shape: HollowShape
    s: Array
    cut: Array
    closed: bool

    @classmethod
    def of(cls, shape: HollowShape, s: Array) -> Contours:
        """Find out whether the outlines need a face, and cut them."""
        near = np.array([0.0, _STEP, 1.0 - _STEP, 1.0])
        start, after, before, end = np.moveaxis(shape.surface(s[:, None], near), 1, 0)
        outline = shape.surface(s[:, None], np.linspace(0.0, 1.0, 65))
        length = np.linalg.norm(np.diff(outline, axis=1), axis=2).sum(axis=1)
        is_open = np.linalg.norm(start - end, axis=1) > _GAP_TOLERANCE * length
        out, back = after - start, before - end
        cosine = np.sum(out * back, axis=1) / np.linalg.norm(out, axis=1)
        sharp = cosine > _SHARP * np.linalg.norm(back, axis=1)
        closed = not (is_open | sharp).any()
        cut = np.zeros_like(s) if closed else _cut(shape, s, _FACE * length)
        return cls(shape, s, cut, closed)

    @property
    def total(self) -> float:
        """Where b ends."""
        return 1.0 if self.closed else 2.0

    def to_b(self, a: Array) -> Array:
        """Coordinate b of contour fractions, shape (S, n)."""
        cut = self.cut[:, None]
        return np.asarray(np.clip((a - cut) / (1.0 - 2.0 * cut), 0.0, 1.0))

    def to_arc(self, b: Array) -> Array:
        """Contour fractions of b, shape (S, n); those cut off are given to what is next to it."""
        cut = self.cut[:, None]
        arc = cut + (1.0 - 2.0 * cut) * np.clip(b, 0.0, 1.0)
        return np.where(b <= 0.0, 0.0, np.where(b >= 1.0, 1.0, arc))

    def points(self, b: Array, step: float = 0.0) -> Array:
        """Points of the outlines.

        Args:
            b: Shape (S, n); beyond its ends it goes round.
            step: Span fraction to go from the sections along the blade at the same b.

        Returns:
            Shape (S, n, 3) [m].
        """
        b = np.where((b < 0.0) | (b > self.total), np.mod(b, self.total), b)
        cut = self.cut[:, None]
        s = np.clip(self.s + step, 0.0, 1.0)[:, None]
        points = self.shape.surface(s, cut + (1.0 - 2.0 * cut) * np.clip(b, 0.0, 1.0))
        if self.closed:
            return points
        first, last = self.shape.surface(s, cut), self.shape.surface(s, 1.0 - cut)
        across = np.clip(b - 1.0, 0.0, 1.0)[..., None]
        return np.where(across > 0.0, (1.0 - across) * last + across * first, points)

    def directions(self, b: Array) -> tuple[Array, Array]:
        """Directions of the outline before and after b, each of shape (S, n, 3) [-]."""
        here = self.points(b)
        steps = here - self.points(b - _STEP), self.points(b + _STEP) - here
        before, after = (v / np.linalg.norm(v, axis=2, keepdims=True) for v in steps)
        return before, after

    def along(self, b: Array) -> Array:
        """Derivative of the points by the span fraction at the same b, shape (S, n, 3) [m]."""
        span = np.clip(self.s + _STEP, 0.0, 1.0) - np.clip(self.s - _STEP, 0.0, 1.0)
        slope: Array = (self.points(b, _STEP) - self.points(b, -_STEP)) / span[:, None, None]
        return slope

    def wall(self, b: Array) -> Array:
        """Thickness of the wall at b, the largest where it jumps, shape (S, n) [m]."""
        a, s = self.to_arc(b), self.s[:, None]
        around = [
            self.shape.wall(np.clip(s + i, 0.0, 1.0), np.clip(a + j, 0.0, 1.0))
            for i in (-_STEP, _STEP)
            for j in (-_STEP, _STEP)
        ]
        return np.asarray(np.max(around, axis=0))


def _cut(shape: HollowShape, s: Array, width: Array) -> Array:
    """Contour fraction at which the trailing edge is so wide, 0 if it is wider, shape (S,)."""

    def is_wider(cut: Array) -> Array:
        edges = shape.surface(s[:, None], np.stack([cut, 1.0 - cut], axis=1))
        return np.asarray(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1) >= width)

    low, high = np.zeros_like(s), np.full_like(s, _DEEPEST_CUT)
    enough = is_wider(low)
    for _ in range(40):
        middle = (low + high) / 2.0
        wider = is_wider(middle)
        low, high = np.where(wider, low, middle), np.where(wider, middle, high)
    return np.where(enough, 0.0, high)
