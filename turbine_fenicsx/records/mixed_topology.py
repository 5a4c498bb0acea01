"""Cells of several kinds as one list of numbers, which XDMF calls a mixed topology."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import ModelError

CELL_KINDS: dict[str, tuple[tuple[int, ...], int]] = {
    "line": ((2, 2), 2),
    "triangle": ((4,), 3),
    "quadrilateral": ((5,), 4),
    "tetrahedron": ((6,), 4),
    "hexahedron": ((9,), 8),
}
"""Cell kind to what stands before its vertices, XDMF's number of the kind and for lines the number
of vertices, and their number."""


def mixed_topology(cells: Sequence[tuple[str, NDArray[Any]]], n_points: int) -> NDArray[np.int32]:
    """Cells as XDMF wants a mixed topology: number of the kind, vertices, number of the kind, ...

    Raises:
        ModelError: if a kind is unknown, a shape is wrong or a point does not exist.
    """
    parts = [np.empty(0, dtype=np.int32)]
    for kind, block in cells:
        if kind not in CELL_KINDS:
            raise ModelError(f"unknown cell kind '{kind}', known are {', '.join(CELL_KINDS)}")
        head, n_vertices = CELL_KINDS[kind]
        vertices = np.asarray(block)
        if vertices.ndim != 2 or vertices.shape[1] != n_vertices:
            raise ModelError(
                f"{kind} cells have shape {vertices.shape}, expected (n, {n_vertices})"
            )
        if vertices.size and not 0 <= vertices.min() <= vertices.max() < n_points:
            raise ModelError(
                f"{kind} cells name points {vertices.min()} to {vertices.max()}, "
                f"there are 0 to {n_points - 1}"
            )
        table = np.empty((len(vertices), len(head) + n_vertices), dtype=np.int32)
        table[:, : len(head)], table[:, len(head) :] = head, vertices
        parts.append(table.ravel())
    return np.concatenate(parts)
