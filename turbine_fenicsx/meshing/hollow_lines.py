"""Lines of a hollow blade around its sections: bounds of panels and of the strips under webs.

Every section has the same lines in the same order. Where the shape would have them cross or meet,
the nearest positions that keep a distance are taken, and what must stay where it is moves least:
webs, and corners of the outline. Cells need not coincide with panels; they know their own range of
the contour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array, BoolArray, IntArray
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow_shape import Contours

_GAP = 0.002  # least distance of two lines over the length of the outline
_THICK = 0.7  # and over the thickness of the wall, which the inner faces at a corner take away
_CORNER_GAP = 1e-5  # least half width of a trailing edge over the length of the outline
_NARROW = 0.005  # a panel as narrow as this on average gets no column of its own
_CORNER = np.cos(np.radians(30.0))  # where the outline turns by more, it has a corner
_THINNEST = 0.1  # a web is at least this part of its largest thickness
_WIDEST = 0.02  # half of a strip under a web, over the length of the outline
_END, _HELD, _FREE, _IDLE = 1e4, 1e2, 1.0, 1e-2  # how hard a line is to move


@dataclass(frozen=True)
class Lines:
    """Where segments of the outline begin and end.

    Attributes:
        positions: Coordinate b of the lines, shape (S, n + 1) [-].
        panel: Panel that each segment belongs to, shape (n,).
        strips: Segments under each web at the suction and the pressure side, shape (n_webs, 2).
        corners: Lines along corners of the outline, shape (n + 1,).
    """

    positions: Array
    panel: IntArray
    strips: IntArray
    corners: BoolArray


@dataclass(frozen=True)
class _Mark:
    """A line, or the middle of a strip; arrays of shape (S,).

    Attributes:
        at: Where it should be [-].
        half: Half of the width of the strip [-].
        gap: Its least distance from others [-].
        fixed: Whether it must not be left out.
        strip: Number of the web and of the side.
    """

    at: Array
    weight: Array
    half: Array
    gap: Array
    fixed: bool
    strip: tuple[int, int] | None = None


def arrange_lines(contours: Contours, most: int) -> Lines:
    """Put bounds of panels and strips of webs in order.

    Args:
        most: Greatest number of segments; bounds of the narrowest panels are left out before.
    """
    bounds = contours.to_b(contours.shape.lines(contours.s))
    marks = _mark_panels(contours, bounds)
    for strip in _mark_strips(contours):
        marks.insert(_place_of(strip, marks), strip)
    _check_order(contours, marks)
    faces = 0 if contours.closed else 1
    marks = _leave_out(marks, most - faces)
    positions, strips, corners = _spread(marks)
    panel = _panel_of(positions, bounds)
    if faces:
        positions = np.hstack([positions, np.full((len(positions), 1), 2.0)])
        panel = np.append(panel, bounds.shape[1] - 2)
        corners = np.append(corners, True)
    return Lines(positions, panel, strips, corners)


def _mark_panels(contours: Contours, bounds: Array) -> list[_Mark]:
    """Bounds of the panels; those at corners and at both ends stay."""
    before, after = contours.directions(bounds)
    corner = np.sum(before * after, axis=2) < _CORNER
    weight = np.where(corner, _HELD, _FREE)
    weight[:, [0, -1]] = _END
    stays = corner.mean(axis=0) > 0.02
    stays[[0, -1]] = True
    gap = np.where(stays, _CORNER_GAP, _least_gap(contours, bounds))
    none = np.zeros(len(bounds))
    return [
        _Mark(bounds[:, i], weight[:, i], none, gap[:, i], bool(stays[i]))
        for i in range(bounds.shape[1])
    ]


def _least_gap(contours: Contours, b: Array) -> Array:
    """How far lines at b should be from others, shape of b [-]."""
    outline = contours.points(np.broadcast_to(np.linspace(0.0, 1.0, 129), (len(b), 129)))
    length = np.linalg.norm(np.diff(outline, axis=1), axis=2).sum(axis=1)
    return np.asarray(np.maximum(_GAP, _THICK * contours.wall(b) / length[:, None]))


def _mark_strips(contours: Contours) -> list[_Mark]:
    """Strips as wide as the webs, at both ends of each."""
    shape, s = contours.shape, contours.s
    marks = []
    for i, web in enumerate(shape.webs):
        inside = np.clip(s, web.start, web.end)
        used = (s > web.start - 1e-9) & (s < web.end + 1e-9)
        at = contours.to_b(shape.web_arcs(i, inside))
        ends = contours.points(at)
        across = ends[:, 1] - ends[:, 0]
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        thickness = shape.web_wall(i, inside)
        thickness = np.maximum(thickness, _THINNEST * thickness.max())
        step = 1e-4
        slope = (contours.points(at + step) - contours.points(at - step)) / (2.0 * step)
        # the wall of the web cuts the outline over its thickness / sin(angle between them)
        width = np.linalg.norm(np.cross(slope, across[:, None]), axis=2)
        speed = np.linalg.norm(slope, axis=2)
        half = thickness[:, None] / 2.0 / np.maximum(width, 0.3 * speed)
        half = np.minimum(half, _WIDEST)
        weight = np.where(used, _HELD, _IDLE)
        gap = _least_gap(contours, at)
        marks += [_Mark(at[:, k], weight, half[:, k], gap[:, k], True, (i, k)) for k in (0, 1)]
    return marks


def _place_of(strip: _Mark, marks: list[_Mark]) -> int:
    """Where a strip belongs among the marks, by their mean distance where its web is."""
    own = strip.weight == _HELD
    before = [float(np.mean((strip.at - mark.at)[own])) > 0.0 for mark in marks]
    return max(1, min(len(marks) - 1, sum(before)))


def _check_order(contours: Contours, marks: list[_Mark]) -> None:
    """Webs must meet the pressure side in the opposite order of the suction side."""
    sides: tuple[list[int], list[int]] = ([], [])
    for mark in marks:
        if mark.strip:
            sides[mark.strip[1]].append(mark.strip[0])
    webs = contours.shape.webs
    for a, b in zip(sides[0], reversed(sides[1]), strict=True):
        if a != b:
            raise MeshError(f"webs {webs[a].name!r} and {webs[b].name!r} of the blade cross")


def _leave_out(marks: list[_Mark], most: int) -> list[_Mark]:
    """Drop bounds of panels that are too narrow, and of the narrowest if there are too many."""
    marks = list(marks)
    while True:
        segments = len(marks) - 1 + sum(mark.strip is not None for mark in marks)
        widths = {}
        for i, mark in enumerate(marks):
            if not mark.fixed:
                sides = (
                    mark.at - marks[i - 1].at - marks[i - 1].half,
                    marks[i + 1].at - marks[i + 1].half - mark.at,
                )
                widths[i] = min(float(np.mean(np.maximum(side, 0.0))) for side in sides)
        narrowest = min(widths, key=lambda i: widths[i]) if widths else None
        if segments > most and narrowest is None:
            raise MeshError(
                f"mesh.around = {most}: the webs and corners of the sections take at least "
                f"{segments} elements around"
            )
        if narrowest is None or (segments <= most and widths[narrowest] >= _NARROW):
            return marks
        del marks[narrowest]


def _spread(marks: list[_Mark]) -> tuple[Array, IntArray, BoolArray]:
    """Nearest positions of all lines that keep their order and distances.

    Weighted least squares with x_i+1 - x_i >= d_i has the solution y_j + D_j, where D_j is the sum
    of d_i before j. Here y is the isotonic regression of x_j - D_j. That is y_j = max over i <= j
    of min over k >= j of the weighted mean from i to k.
    """
    at, weight, half, gap = (
        np.stack([getattr(mark, name) for mark in marks], axis=1)
        for name in ("at", "weight", "half", "gap")
    )
    distance = np.maximum(gap[:, :-1], gap[:, 1:]) + half[:, :-1] + half[:, 1:]
    distance = np.cumsum(distance, axis=1)
    distance = np.hstack([np.zeros((len(at), 1)), distance])
    distance *= np.minimum(1.0, 0.9 / distance[:, -1:])
    sums = [
        np.hstack([np.zeros((len(at), 1)), np.cumsum(v, axis=1)])
        for v in (weight, weight * (at - distance))
    ]
    total, moment = (v[:, None, 1:] - v[:, :-1, None] for v in sums)
    mean = np.where(total > 0.0, moment / np.where(total > 0.0, total, 1.0), np.inf)
    lower = np.minimum.accumulate(mean[:, :, ::-1], axis=2)[:, :, ::-1]
    first, last = np.indices(lower.shape[1:])
    y = np.where(first <= last, lower, -np.inf).max(axis=1)
    x = np.clip(y, 0.0, 1.0 - distance[:, -1:]) + distance
    x[:, 0], x[:, -1] = 0.0, 1.0

    lines: list[Array] = []
    corners: list[bool] = []
    strips = np.zeros((sum(mark.strip is not None for mark in marks) // 2, 2), dtype=np.int64)
    for i, mark in enumerate(marks):
        if mark.strip is None:
            lines.append(x[:, i])
            corners.append(mark.fixed)
        else:
            strips[mark.strip] = len(lines)
            lines += [x[:, i] - mark.half, x[:, i] + mark.half]
            corners += [False, False]
    return np.stack(lines, axis=1), strips, np.array(corners)


def _panel_of(positions: Array, bounds: Array) -> IntArray:
    """The panel that covers most of each segment."""
    low = np.maximum(positions[:, :-1, None], bounds[:, None, :-1])
    high = np.minimum(positions[:, 1:, None], bounds[:, None, 1:])
    return np.asarray(np.argmax(np.maximum(high - low, 0.0).mean(axis=0), axis=1))


_FINE = 24  # parts of a segment in which its outline is looked at
_CURVATURE = 0.3  # a full turn of the outline counts like this part of its length
_WAY_IN = 0.3  # way from a line into a column to where its wall is measured
_WIDTH = 1.5  # width of a column over the thickness of the wall
_CLOSEST = 2.0  # nowhere more than this many times its own length


@dataclass(frozen=True)
class Columns:
    """Columns of elements around all sections.

    Attributes:
        b: Coordinates of the lines between them, shape (S, C + 1) [-].
        inside: Where the wall at each line is measured, shape (S, C + 1) [-]: where walls of
            different thickness meet, the narrower panel keeps its own up to the line.
        panel: Panel that each column belongs to, shape (C,).
        strips: Columns under each web at the suction and the pressure side, shape (n_webs, 2).
        outline: Closely spaced points of the outlines, shape (S, n, 3) [m].
    """

    b: Array
    inside: Array
    panel: IntArray
    strips: IntArray
    outline: Array


def divide_sections(contours: Contours, n_around: int) -> Columns:
    """Divide sections into elements that are shorter where the outline is curved.

    Every segment between lines gets one column, each further one goes to the segment with the
    longest elements; only the strips under webs stay undivided.

    Args:
        n_around: Number of elements around a section.
    """
    lines = arrange_lines(contours, n_around)
    x = lines.positions
    t = np.linspace(0.0, 1.0, _FINE + 1)
    # closer at both ends: a trailing edge is narrow beside the panels next to it
    clustered = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    fine = x[:, :-1, None] + np.diff(x, axis=1)[..., None] * clustered
    points = contours.points(fine.reshape(len(x), -1))
    size = _cumulate_size(points.reshape(*fine.shape, 3))
    most = _count_wide_columns(contours, lines, points.reshape(*fine.shape, 3))
    width = size[..., -1].mean(axis=0)
    panels = np.asarray(np.bincount(lines.panel, weights=width), dtype=np.float64)
    counts = _share_out(lines, width, most, n_around)
    vertices = [
        _invert(size[:, j], fine[:, j], np.arange(count) / count) for j, count in enumerate(counts)
    ]
    first = np.concatenate([[0], np.cumsum(counts)])
    b = np.hstack([*vertices, x[:, -1:]])
    _straighten(b, first[lines.corners])
    return Columns(
        b=b,
        inside=_look_inside(b, first, panels[lines.panel]),
        panel=np.repeat(lines.panel, counts),
        strips=first[lines.strips],
        outline=points,
    )


def _straighten(b: Array, corners: IntArray) -> None:
    """Put lines half-way in the middle sections of elements, where they are at no corner.

    Otherwise narrow cells whose width changes by much from one end to the other would fold. A line
    that a corner would pass goes where the width in the middle is (w_0 + w_1)/4: the width of a
    quadratic cell is w_0 (1 - t)^2 + w_1 t^2 then, which has no zero.
    """
    at_corners = b[1::2, corners]
    widths = np.diff(b[:-2:2] + b[2::2], axis=1) / 4.0
    b[1::2] = (b[:-2:2] + b[2::2]) / 2.0
    middle = b[1::2]
    middle[:, corners] = at_corners
    others = np.setdiff1d(np.arange(1, b.shape[1] - 1), corners)
    for k in others[np.isin(others - 1, corners)]:
        passed = middle[:, k] <= middle[:, k - 1]
        middle[passed, k] = (middle[:, k - 1] + widths[:, k - 1])[passed]
    for k in others[np.isin(others + 1, corners)]:
        passed = middle[:, k] >= middle[:, k + 1]
        middle[passed, k] = (middle[:, k + 1] - widths[:, k])[passed]


def _look_inside(b: Array, first: IntArray, size: Array) -> Array:
    """Coordinates some way from each line into the segment beside it whose panel is narrower.

    Args:
        b: Coordinates of the lines of columns, shape (S, C + 1) [-].
        first: Lines between segments, shape (J + 1,).
        size: How wide the panels of the segments are, shape (J,).
    """
    inside = b.copy()
    line = first[1:-1]
    before = np.where(size[:-1] < size[1:], 1, 0)
    into = np.where(before, b[:, line - 1], b[:, line + 1])
    inside[:, line] += _WAY_IN * (into - b[:, line])
    return inside


def _cumulate_size(points: Array) -> Array:
    """Length plus turning from the start of each segment, over all of a section.

    Args:
        points: Shape (S, J, F + 1, 3) [m].

    Returns:
        Shape (S, J, F + 1) [-].
    """
    steps = np.diff(points, axis=2)
    length = np.linalg.norm(steps, axis=3)
    unit = steps / length[..., None]
    cosine = np.sum(unit[:, :, 1:] * unit[:, :, :-1], axis=3)
    turning = np.arccos(np.clip(cosine, -1.0, 1.0)) / (4.0 * np.pi)
    size = length / length.sum(axis=(1, 2), keepdims=True)
    curved = np.zeros_like(size)
    curved[:, :, 1:] += _CURVATURE * turning
    curved[:, :, :-1] += _CURVATURE * turning
    size += np.minimum(curved, _CLOSEST * size)
    return np.concatenate([np.zeros_like(size[:, :, :1]), np.cumsum(size, axis=2)], axis=2)


def _count_wide_columns(contours: Contours, lines: Lines, points: Array) -> Array:
    """How many columns fit into each segment that are wider than the wall is thick, shape (J,)."""
    width = np.linalg.norm(np.diff(points, axis=2), axis=3).sum(axis=2)
    middle = (lines.positions[:, 1:] + lines.positions[:, :-1]) / 2.0
    return np.asarray((width / (_WIDTH * contours.wall(middle))).min(axis=0))


def _share_out(lines: Lines, size: Array, most: Array, n_around: int) -> IntArray:
    """Number of columns of each segment; where no more fit, they become narrow everywhere."""
    counts = np.ones(len(size), dtype=np.int64)
    divisible = np.ones(len(size), dtype=bool)
    divisible[lines.strips.ravel()] = False
    for _ in range(n_around - len(counts)):
        fitting = divisible & (counts + 1 <= most)
        wish = np.where(fitting, size, 0.0) if fitting.any() else np.where(divisible, most, 0.0)
        counts[np.argmax(wish / counts)] += 1
    return counts


def _invert(size: Array, b: Array, parts: Array) -> Array:
    """Where a growing size reaches parts of its end, shape (S, n); size and b are (S, F + 1)."""
    target = parts * size[:, -1:]
    right = np.clip((size[:, None, :] <= target[..., None]).sum(axis=2), 1, size.shape[1] - 1)
    low, high = (np.take_along_axis(size, i, axis=1) for i in (right - 1, right))
    start, end = (np.take_along_axis(b, i, axis=1) for i in (right - 1, right))
    part: Array = (target - low) / (high - low)
    return start + part * (end - start)
