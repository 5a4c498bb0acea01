"""Cells inside the wall of a hollow blade: webs, and a plate that closes the tip.

Without a plate the long cells at the end of the blade open and shut like a mouth, with nothing to
stop them but the bending of their walls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import groupby

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.hollow_shape import HollowShape
from turbine_fenicsx.meshing.quality import scaled_jacobian

HEXAHEDRON = reference_cell("hexahedron", 2)
_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


@dataclass(frozen=True)
class Cells:
    """Cells and what they are part of; the attributes are those of `HollowBlock`."""

    cells: IntArray
    part: IntArray
    span: Array
    arc: Array
    wanted: Array
    thickness: Array

    @classmethod
    def join(cls, groups: Sequence[Cells]) -> Cells:
        """All cells of some groups, one group after the other."""
        return cls(
            *(np.concatenate([getattr(g, field.name) for g in groups]) for field in fields(cls))
        )


def cells_of_grid(number: IntArray) -> IntArray:
    """Quadratic hexahedra on a grid of nodes.

    Args:
        number: Nodes along, around and through, shape (2 m + 1, 2 n + 1, 3).

    Returns:
        Nodes of the cells in gmsh's order, shape (m, n, 27).
    """
    i, j, k = HEXAHEDRON.lattice.T
    first, second = (2 * np.arange(size // 2)[:, None] for size in number.shape[:2])
    return np.asarray(number[(first + i)[:, None], (second + j)[None], k])


def mean_of_cells(values: Array) -> Array:
    """Means over cells of what is known at the nodes of one face of a grid.

    Args:
        values: Shape (2 m + 1, 2 n + 1).

    Returns:
        Shape (m, n), by Simpson's rule.
    """
    along = sum(w * values[k : len(values) - 2 + k : 2] for k, w in enumerate(_SIMPSON))
    n = values.shape[1]
    return np.asarray(sum(w * along[:, k : n - 2 + k : 2] for k, w in enumerate(_SIMPSON)))


_SAMPLES = np.array([0.125, 0.375, 0.625, 0.875])  # of an element along the span


def mesh_web(
    shape: HollowShape,
    web: int,
    lines: Array,
    points: Array,
    ends: tuple[IntArray, IntArray],
    length: float,
) -> tuple[Array, Cells]:
    """Mesh one web.

    Args:
        web: Number of the web.
        lines: Span fractions of the lines along the span, shape (M + 1,) [-].
        points: Nodes so far, shape (n, 3) [m].
        ends: Nodes inside the strips at the suction and the pressure side, from the trailing
            to the leading edge, shape (2 M + 1, 3) each.
        length: Wanted length of elements from one end to the other [m].

    Returns:
        The nodes that join those there are, shape (m, 3) [m], and the cells.
    """
    first, last = (
        int(np.argmin(np.abs(lines - at))) for at in (shape.webs[web].start, shape.webs[web].end)
    )
    top, bottom = (nodes[2 * first : 2 * last + 1] for nodes in ends)
    across = points[bottom] - points[top]
    height = np.linalg.norm(across, axis=2)
    n = max(1, round(float(height.mean()) / length))
    part = np.linspace(0.0, 1.0, 2 * n + 1)[:, None, None]
    grid = points[top][:, None] + part * across[:, None]
    inner = grid[:, 1:-1]
    number = np.empty(grid.shape[:3], dtype=np.int64)
    number[:, 0], number[:, -1] = top, bottom
    number[:, 1:-1] = len(points) + np.arange(inner[..., 0].size).reshape(inner.shape[:3])

    cells = cells_of_grid(number)
    m = last - first
    span = np.stack([lines[first:last], lines[first + 1 : last + 1]], axis=1)
    s = span[:, :1] + np.diff(span, axis=1) * _SAMPLES
    wanted = shape.web_wall(web, s.ravel()).reshape(s.shape).mean(axis=1)
    heights = np.linspace(0.0, 1.0, n + 1)
    return inner.reshape(-1, 3), Cells(
        cells=cells.reshape(-1, 27),
        part=np.full(m * n, len(shape.panels) + web),
        span=np.repeat(span, n, axis=0),
        arc=np.tile(np.stack([heights[:-1], heights[1:]], axis=1), (m, 1)),
        wanted=np.repeat(wanted, n),
        thickness=mean_of_cells(_thickness(grid)).ravel(),
    )


def _thickness(grid: Array) -> Array:
    """Distance of the faces of a web, normal to its middle, shape (2 m + 1, 2 n + 1) [m]."""
    along, up = (np.gradient(grid[:, :, 1], axis=k) for k in (0, 1))
    normal = np.cross(along, up)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return np.asarray(np.abs(np.sum((grid[:, :, 2] - grid[:, :, 0]) * normal, axis=2)))


TIP = "tip"
"""Name of the plate among the parts of a block."""

_LEAST_QUALITY = 0.4  # scaled Jacobian; what is worse, or lower than thick, stays open
_SHIFTS = 3  # lines by which sides with different numbers of columns may be shifted
_ARCS = np.linspace(0.0, 1.0, 65)


def add_tip_row(shape: HollowShape, lines: Array) -> Array:
    """Lines along the span with a row of cells at the tip as long as the wall is thick there."""
    thickness = float(np.mean(shape.wall(lines[-1:], _ARCS)))
    row = min(thickness / shape.length, (lines[-1] - lines[-2]) / 2.0)
    return np.concatenate([lines[:-1], [lines[-1] - row, lines[-1]]])


def mesh_tip(
    shape: HollowShape, part: int, lines: Array, arcs: Array, ring: IntArray, points: Array
) -> tuple[Array, Cells]:
    """Mesh the plate between the inner faces of suction and pressure side.

    Lines are counted from the trailing edge on both sides, shifted against each other such that as
    many columns as possible face each other; these are joined. The first and the last ones are left
    out, which meet at the edges.

    Args:
        part: Number of the plate among the parts.
        lines: Span fractions of the lines along the span, shape (M + 1,) [-].
        arcs: Contour fractions of the lines around the tip, shape (C + 1,) [-].
        ring: Nodes of the wall along, around and through, shape (2 M + 1, 2 C + 1, 3).
        points: Nodes so far, shape (n, 3) [m].

    Returns:
        The nodes that join those there are, shape (m, 3) [m], and the cells, whose axes point from
        suction to pressure side, to the leading edge, and along the span.
    """
    inner = ring[-3:, :, 0].T
    sides = [_find_run(points, inner, shift) for shift in range(-_SHIFTS, _SHIFTS + 1)]
    first, top, bottom = max(sides, key=lambda side: len(side[1]))
    middle = (points[top] + points[bottom]) / 2.0
    new = len(points) + np.arange(top.size).reshape(top.shape)
    last = first + len(top) // 2
    arc = np.stack([arcs[first:last], arcs[first + 1 : last + 1]], axis=1)
    thickness = np.linalg.norm(middle[:, 2] - middle[:, 0], axis=1)
    return middle.reshape(-1, 3), Cells(
        cells=cells_of_grid(np.stack([top, new, bottom])).reshape(-1, 27),
        part=np.full(last - first, part),
        span=np.tile(lines[-2:], (last - first, 1)),
        arc=arc,
        wanted=np.asarray(shape.wall(lines[-1:], arc.mean(axis=1))),
        thickness=thickness[1::2],
    )


def _find_run(points: Array, inner: IntArray, shift: int) -> tuple[int, IntArray, IntArray]:
    """The longest row of columns that face each other, if one side is shifted against the other.

    Args:
        points: All nodes, shape (n, 3) [m].
        inner: Inner nodes around the tip in its last three sections, shape (2 C + 1, 3).
        shift: Lines by which the pressure side is ahead.

    Returns:
        Its first line, counted from the trailing edge on the suction side, and the nodes on the
        suction and the pressure side, shape (2 n + 1, 3).
    """
    start = max(1, 1 - shift)
    end = (len(inner) // 2 - shift) // 2 - 1
    top = inner[2 * start : 2 * end + 1]
    bottom = inner[::-1][2 * (start + shift) : 2 * (end + shift) + 1]
    if end <= start:
        return start, inner[:0], inner[:0]
    corners = np.stack([points[top], (points[top] + points[bottom]) / 2.0, points[bottom]])
    cells = cells_of_grid(np.arange(3 * top.size).reshape(3, *top.shape)).reshape(-1, 27)
    good = scaled_jacobian(corners.reshape(-1, 3), cells, HEXAHEDRON) > _LEAST_QUALITY
    height = np.linalg.norm(corners[2] - corners[0], axis=2).min(axis=1)
    thickness = np.linalg.norm(corners[0, :, 2] - corners[0, :, 0], axis=1).max()
    good &= np.minimum(height[:-1:2], height[2::2]) > thickness
    runs = [list(run) for key, run in groupby(range(len(good)), lambda i: bool(good[i])) if key]
    run = max(runs, key=len, default=[])
    nodes = slice(2 * run[0], 2 * run[-1] + 3) if run else slice(0, 0)
    return start + (run[0] if run else 0), top[nodes], bottom[nodes]
