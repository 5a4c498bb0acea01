"""Nodes of the wall in the sections of a hollow blade.

Outer nodes lie on the surface. Inner nodes lie in the plane of the section, so far inside that the
thickness along the normal of the surface is that of the wall. At a corner they lie where the inner
faces of both walls meet. Walls stay thinner than part of the inscribed ball that touches the
surface there, so that opposite walls never meet, as they would at trailing and leading edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.hollow_shape import Contours

_FILL = 0.6  # thickest wall over the radius of the inscribed ball
_TOUCH = 0.97  # the ball is as large as 97 % of its radius fits
_SHARPEST = 0.3  # cosine of half the turning angle beyond which a corner is cut
_CORNER = (
    0.94  # that cosine below which balls in a cell beside do not fit without those at its ends
)
_STRAIGHT = 0.985  # that cosine above which the outline is smooth
_ROOM = 3.0  # nodes move away from a corner within this many times the larger of t and that
_FLATTEST = 0.5  # least cosine between surface normal and section
_SWING = 0.3  # the thickness in the middle of a cell over the mean of its ends, less 1
_TOLERANCE = 1e-18  # squared distance of points that are one, over that of those farthest away


@dataclass(frozen=True)
class Wall:
    """Where the wall begins, where it goes and how thick it may be.

    Attributes:
        outer: Nodes on the surface, shape (S, n, 3) [m].
        inner: Nodes on the inner face, shape (S, n, 3) [m].
        thickness: Thickness of the wall, shape (S, n) [m].
    """

    outer: Array
    inner: Array
    thickness: Array

    @property
    def nodes(self) -> Array:
        """Nodes from the inner to the outer face, shape (S, n, 3, 3) [m]."""
        return np.stack([self.inner, (self.inner + self.outer) / 2.0, self.outer], axis=2)


def build_wall(
    contours: Contours, b: Array, inside: Array, outline: Array, share: Array | None = None
) -> Wall:
    """Find the wall at the nodes of all sections.

    Args:
        b: Coordinates of the nodes, shape (S, n) [-].
        inside: Coordinates where the thickness at the nodes is measured, shape (S, n) [-].
        outline: Closely spaced points of the outlines, shape (S, m, 3) [m].
        share: What of the thickness that has room is taken, shape (S, n) [-]; all of it if None.
    """
    outer = contours.points(b)
    before, after = contours.directions(b)
    plane = _area_vectors(outline)[:, None]
    # inwards in the plane of the section: e x t for an outline that runs about e
    along = _unit(before + after)
    normal = np.cross(plane, along)
    half_turn = np.sum(normal * np.cross(plane, after), axis=2)
    surface = _unit(np.cross(contours.along(b), along))
    slope = np.abs(np.sum(surface * normal, axis=2))
    stretch = np.maximum(half_turn, _SHARPEST)
    miter = normal / stretch[..., None]
    slope = np.maximum(slope, _FLATTEST)
    radius = np.stack(
        [_ball_radius(*section) for section in zip(outer, miter, outline, strict=True)]
    )
    corner = (half_turn < _CORNER)[:, ::2]
    ends = radius[:, ::2]
    radius[:, 1::2] = np.where(
        corner | np.roll(corner, -1, axis=1),
        (ends + np.roll(ends, -1, axis=1)) / 2.0,
        radius[:, 1::2],
    )
    thickness = np.minimum(contours.wall(inside), _FILL * radius * slope)
    thickness *= 1.0 if share is None else share
    _temper(thickness[1::2], thickness[:-2:2], thickness[2::2])
    _temper(thickness[:, 1::2], thickness[:, ::2], np.roll(thickness[:, ::2], -1, axis=1))
    inner = outer + (thickness / slope)[..., None] * miter
    _make_room(outer, inner, thickness, half_turn, along)
    return Wall(outer, inner, thickness)


def _temper(middle: Array, before: Array, after: Array) -> None:
    """Keep the thickness in the middle of cells near the mean of both ends, or it would swing."""
    mean = (before + after) / 2.0
    np.clip(middle, (1.0 - _SWING) * mean, (1.0 + _SWING) * mean, out=middle)


def _make_room(
    outer: Array, inner: Array, thickness: Array, half_turn: Array, along: Array
) -> None:
    """Shift inner nodes beside a corner away from it, in place.

    There the inner face is shorter than the outer one by t tan(turn / 2); nodes closer to the
    corner than some times that, and than the next corner, share that between them.

    Args:
        outer: Outer nodes, shape (S, n, 3) [m].
        inner: Inner nodes, shape (S, n, 3) [m].
        thickness: Thickness of the wall, shape (S, n) [m].
        half_turn: Cosine of half the angle by which the outline turns, shape (S, n) [-].
        along: Direction of the outline, shape (S, n, 3) [-].
    """
    steps = np.linalg.norm(np.roll(outer, -1, axis=1) - outer, axis=2)
    place = np.cumsum(steps, axis=1) - steps
    length = steps.sum(axis=1, keepdims=True)
    shift = np.zeros_like(thickness)
    corners = np.flatnonzero((half_turn < _STRAIGHT).any(axis=0))
    for corner in corners:
        cosine = np.maximum(half_turn[:, [corner]], _SHARPEST)
        t = thickness[:, [corner]]
        distance = np.mod(place - place[:, [corner]] + length / 2.0, length) - length / 2.0
        lost = t * np.sqrt(np.maximum(0.0, 1.0 - cosine**2)) / cosine
        to_next = np.abs(distance[:, corners[corners != corner]]).min(axis=1, initial=np.inf)
        room = np.minimum(_ROOM * np.maximum(t, lost), to_next[:, None])
        share = np.maximum(0.0, 1.0 - np.abs(distance) / room)
        shift += np.sign(distance) * share * lost
    inner += shift[..., None] * along


def _unit(vectors: Array) -> Array:
    """Vectors divided by their lengths."""
    scaled: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return scaled


def _area_vectors(outline: Array) -> Array:
    """Unit vectors about which the outlines run, shape (S, 3)."""
    arms = outline - outline.mean(axis=1, keepdims=True)
    return _unit(np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1))


def _ball_radius(points: Array, miters: Array, outline: Array) -> Array:
    """Radius of the largest ball inside that touches the sides of a section at each point.

    The ball of radius r has its centre at p + r m, where m is the normal or, at a corner, goes to
    where both offset sides meet. A point q = p + d of the outline is outside of a ball of radius
    c r about it, if

        |d|^2 - 2 r d.m + r^2 (|m|^2 - c^2) > 0,

    that is for r below the smaller root; c is a little less than 1, so that the sides at which
    the ball touches do not count.

    Args:
        points: Shape (n, 3) [m].
        miters: Shape (n, 3) [-].
        outline: Shape (m, 3) [m].

    Returns:
        Shape (n,) [m].
    """
    d = outline - points[:, None]
    squared = np.sum(d * d, axis=2)
    along = np.einsum("nmi,ni->nm", d, miters)
    excess = np.sum(miters * miters, axis=1, keepdims=True) - _TOUCH**2
    root = along**2 - squared * excess
    near = (root >= 0.0) & (along > 0.0) & (squared > _TOLERANCE * squared.max())
    r = (along - np.sqrt(np.where(near, root, 0.0))) / excess
    return np.asarray(np.where(near, r, np.inf).min(axis=1))
