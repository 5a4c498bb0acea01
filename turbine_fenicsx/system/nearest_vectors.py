"""Vectors of a basis whose motion is nearest to a given one."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.foundation.types import Array


def find_nearest_vectors(basis: ReducedBasis, values: Array, free: Array) -> Array:
    """Vectors whose motion is nearest to one of the nodes, by their masses.

    Args:
        basis: The basis.
        values: Motion of the nodes of all copies, shape (copies N, 3).
        free: Which vectors may move, shape (copies, n).

    Returns:
        Shape (copies, n, 3), zero for the others.
    """
    found = np.zeros((*free.shape, 3))
    root = np.sqrt(basis.masses)[:, None]
    for copy, of_nodes in enumerate(values.reshape(len(free), -1, 3)):
        columns = root * basis.functions[:, free[copy]]
        found[copy, free[copy]] = np.linalg.lstsq(columns, root * of_nodes, rcond=None)[0]
    return found
