"""Nodes on a surface of a body by their positions, whatever ranks own them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.owned_nodes import nodes_of_facets
from turbine_fenicsx.foundation.types import Array


def find_surface_points(space: Any, name: str, facets: npt.ArrayLike) -> Array:
    """Initial positions of the nodes on some facets, shape (n, 3) [m], equal on all ranks.

    Args:
        space: Space of the displacement of the body.
        name: Name of what holds the facets, for errors.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).

    Note:
        Collective.
    """
    nodes = nodes_of_facets(space, check_facets(name, space.mesh, facets))
    own = space.tabulate_dof_coordinates()[nodes]
    found: Array = np.concatenate(space.mesh.comm.allgather(own))
    return found
