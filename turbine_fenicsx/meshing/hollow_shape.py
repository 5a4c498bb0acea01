"""Shapes for the mesher of hollow blades: outer surface, walls, lines, webs, closed outlines.

A point of the outer surface has two coordinates. s is the fraction of the span, from 0 at the root
to 1 at the tip. The fraction a of the contour of a section is 0 at the trailing edge. It rises
along the suction side over the leading edge and back along the pressure side to 1, the same point
again. Where the trailing edge is flat and thick, this point is the middle of its face. Then the
first and the last panel, called "trailing edge", are the halves of the face; the second line and
the last but one are its corners. At a sharp trailing edge these panels have no width.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.blade import BladeGeometry


@dataclass(frozen=True)
class Web:
    """A shear web from the suction to the pressure side.

    Args:
        start: Fraction of the span where it begins [-].
        end: Fraction of the span where it ends [-].
    """

    name: str
    start: float
    end: float


class HollowShape(Protocol):
    """Outer surface, walls and webs of a blade, in its own frame.

    The frame is that of `turbine_fenicsx.meshing.RotorLayout`: a1 along the span, a2 towards the
    leading edge, a3 = a1 x a2 towards the suction side. Its origin is the rotor centre, so the root
    lies in the plane a1 = hub_radius.
    """

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""

    @property
    def length(self) -> float:
        """Length of the span [m]."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Span fractions, rising from 0 to 1, where something begins, ends or has a kink."""

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the n panels around a section, from a = 0 to a = 1; names may repeat."""

    @property
    def webs(self) -> tuple[Web, ...]:
        """The shear webs."""

    @property
    def closed_tip(self) -> bool:
        """Whether a plate as thick as the wall closes the tip."""

    def lines(self, s: Array) -> Array:
        """Contour fractions that bound the panels at span fractions s.

        Args:
            s: Shape (m,) [-].

        Returns:
            Shape (m, n + 1) [-], not falling along each row, from 0 to 1; equal neighbours are a
            panel of no width there.
        """

    def web_arcs(self, web: int, s: Array) -> Array:
        """Contour fractions where the middle of a web meets suction and pressure side, (m, 2)."""

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the outer surface.

        Args:
            s: Span fractions [-].
            a: Contour fractions, of a shape that broadcasts with s [-].

        Returns:
            Coordinates along a1, a2, a3, one axis more than the arguments [m].
        """

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall there [m]; the arguments as in `surface`."""

    def web_wall(self, web: int, s: Array) -> Array:
        """Thickness of a web, shape (m,) [m]."""


_GAP_TOLERANCE = 1e-6  # a gap of this part of the outline is open
_SHARP = np.cos(np.radians(60.0))  # an edge with a smaller angle inside is sharp
_FACE = 5e-4  # least width of the face over the length of the outline
_DEEPEST_CUT = 0.05  # contour fraction
_STEP = 1e-6  # step of one-sided derivatives in contour and span fractions


@dataclass(frozen=True)
class Contours:
    """Closed outlines of sections.

    An outline whose trailing edge is open or sharp is closed by a narrow face: hexahedra cannot
    fill a wedge of a few degrees, and real trailing edges are not sharp. Where the edge is narrower
    than a small part of the outline, it is cut off where it is that wide. The coordinate b runs
    from 0 to 1 like the contour fraction and, where there is such a face, on from 1 to 2 across it.

    Attributes:
        s: Span fractions of the sections, shape (S,) [-].
        cut: Contour fraction cut off at either side of the trailing edge, shape (S,) [-].
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


@dataclass(frozen=True)
class EllipticShape:
    """Tapered, twisted ellipses without webs, a `turbine_fenicsx.meshing.hollow_shape.HollowShape`.

    The contour fraction is the angle about the middle of the section over a full turn, in a circle
    that is stretched to the ellipse.

    Args:
        geometry: The blade; a mesher of hollow ones needs its wall.
    """

    geometry: BladeGeometry

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""
        return self.geometry.hub_radius

    @property
    def length(self) -> float:
        """Length of the span [m]."""
        return self.geometry.length

    @property
    def closed_tip(self) -> bool:
        """True."""
        return True

    @property
    def breaks(self) -> tuple[float, ...]:
        """Stations with kinks."""
        return self.geometry.kinks

    @property
    def panels(self) -> tuple[str, ...]:
        """Both sides."""
        return "suction side", "pressure side"

    @property
    def webs(self) -> tuple[Web, ...]:
        """None."""
        return ()

    def lines(self, s: Array) -> Array:
        """Trailing edge, leading edge, trailing edge, shape (m, 3) [-]."""
        return np.tile([0.0, 0.5, 1.0], (len(s), 1))

    def leading(self, s: Array) -> Array:
        """Contour fraction of the leading edge, shape (m,) [-]."""
        return np.full(len(s), 0.5)

    def web_arcs(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the ellipses, one axis more than the arguments [m]."""
        s, a = np.broadcast_arrays(s, a)
        g, angle = self.geometry, 2.0 * np.pi * a
        x = g.hub_radius + g.length * s
        across = -0.5 * g.chord_at(s) * np.cos(angle)
        through = 0.5 * g.thickness_at(s) * np.sin(angle)
        return g.turn(np.stack([x, across, through], axis=-1))

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall [m]."""
        return self.geometry.wall_at(np.broadcast_arrays(s, a)[0])

    def web_wall(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)
