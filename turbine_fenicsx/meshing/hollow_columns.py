"""Columns of elements between the lines around a section."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.hollow_contour import Contours
from turbine_fenicsx.meshing.hollow_lines import Lines, arrange_lines

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
        contours: The outlines.
        n_around: Number of elements around a section.

    Returns:
        The columns.
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
