"""Cells of the webs, between the inner faces of the wall."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.hollow_cells import Cells, cells_of_grid, mean_of_cells
from turbine_fenicsx.meshing.hollow_shape import HollowShape

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
        shape: The blade.
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
