"""Check of the mesh of a body."""

from __future__ import annotations

from dolfinx.mesh import Mesh

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError

CELLS = ("hexahedron", "tetrahedron")
"""Cells that a mesh may have."""


def check_body_mesh(name: str, mesh: Mesh, degree: int) -> None:
    """Raise a ModelError for a mesh of other cells, or another degree than 1 or 2.

    Args:
        name: Name of the body.
        degree: Polynomial degree of its displacement.
    """
    if degree not in (1, 2):
        raise ModelError(f"degree of {name!r} must be 1 or 2, got {degree}")
    dims, cell = (mesh.topology.dim, mesh.geometry.dim), _compat.cell_name(mesh)
    if dims != (3, 3) or cell not in CELLS:
        raise ModelError(
            f"mesh of {name!r} must be three-dimensional, of {' or '.join(CELLS)} cells; "
            f"got {cell} cells in {dims[1]} dimensions"
        )
