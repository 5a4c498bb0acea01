"""Facets of couplings and surface forces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from dolfinx.mesh import Mesh

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together


def check_facets(name: str, mesh: Mesh, facets: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """Sorted numbers of facets of this rank, ghosts included, each once. Collective.

    Args:
        name: Name of the part that they were given to.
    """
    mesh.topology.create_entities(2)
    index_map = mesh.topology.index_map(2)
    count = index_map.size_local + index_map.num_ghosts
    given, error = np.asarray(facets), None
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        error = ModelError(
            f"facets of {name!r} must be a list of numbers of facets, as dolfinx.mesh."
            f"locate_entities_boundary or the find() of mesh tags return them, got {facets!r}"
        )
    elif np.any((given < 0) | (given >= count)):
        error = ModelError(
            f"facets of {name!r} must be below {count}, the number of facets of the mesh on this "
            f"rank, got {given.min()} to {given.max()}"
        )
    raise_together(mesh.comm, error)
    each: npt.NDArray[np.int32] = np.unique(given).astype(np.int32)
    return each
