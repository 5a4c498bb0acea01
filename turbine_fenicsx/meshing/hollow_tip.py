"""A plate that closes the tip of a hollow blade.

Without one the long cells at the end of the blade open and shut like a mouth, with nothing to stop
them but the bending of their walls.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.hollow_cells import HEXAHEDRON, Cells, cells_of_grid
from turbine_fenicsx.meshing.hollow_shape import HollowShape
from turbine_fenicsx.meshing.quality import scaled_jacobian

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
        shape: The blade.
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
