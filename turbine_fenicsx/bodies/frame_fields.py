"""Material axes that vary from part to part of a mesh."""

from __future__ import annotations

from typing import Any

from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.core.expr import Expr

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array

Frame = tuple[Expr, Expr, Expr]
"""Axes a1 (span), a2 (chord), a3 (thickness) as UFL vectors."""


def frame_fields(mesh: Mesh, cell_tags: Any, frames: dict[int, Array]) -> Frame:
    """One frame per tagged part of a mesh, as cellwise constant fields.

    Args:
        mesh: The mesh.
        cell_tags: Cell tags of the parts.
        frames: Axes as rows, shape (3, 3), by tag.

    Returns:
        The three axes as functions on the mesh.
    """
    space = _compat.cellwise_space(mesh, (3,))
    dofs = _compat.dofs_of_cells(space)[:, 0]
    axes = []
    for k in range(3):
        axis = fem.Function(space)
        values = axis.x.array.reshape(-1, 3)
        for tag, frame in frames.items():
            values[dofs[cell_tags.indices[cell_tags.values == tag]]] = frame[k]
        axis.x.scatter_forward()
        axes.append(axis)
    return axes[0], axes[1], axes[2]
