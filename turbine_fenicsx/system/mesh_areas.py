"""Shares of a surface that the nodes of a mesh have, and where these nodes are."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.foundation.types import Array


def find_areas(space: Any, name: str, facets: npt.ArrayLike) -> Array:
    """Area of facets that belongs to each owned node, shape (n_owned,) [m^2]. Collective.

    Args:
        space: Space of the displacement.
        name: Name of what acts on them, for errors.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
    """
    mesh, index_map = space.mesh, space.dofmap.index_map
    found = check_facets(name, mesh, facets)
    ds = _compat.facet_measure(mesh, found, np.ones(found.size, dtype=np.int32))
    ones = fem.Constant(mesh, PETSc.ScalarType((1.0, 1.0, 1.0)))
    vector = PETSc.Vec().createGhost(
        index_map.ghosts.astype(PETSc.IntType),
        size=(3 * index_map.size_local, 3 * index_map.size_global),
        bsize=3,
        comm=mesh.comm,
    )
    form = ufl.dot(ones, ufl.TestFunction(space)) * ds(1)
    _compat.assemble_vector(vector, _compat.compile_form(form))
    areas = np.array(vector.array_r[::3])
    vector.destroy()
    # some shape functions have the mean zero on a face: round-off is no area
    return np.where(np.abs(areas) > 1e-12 * np.max(np.abs(areas), initial=0.0), areas, 0.0)


def positions_of(space: Any) -> Array:
    """Positions of the owned nodes in the initial configuration, shape (n_owned, 3) [m]."""
    found: Array = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    return found
