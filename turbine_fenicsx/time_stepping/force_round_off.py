"""Round-off of the forces of a flexible body in a step: what no iteration can get below.

The strain of a step comes from F = I + grad(u_n + du/2). The contribution of u_n is the same in all
iterations, and so is its round-off. With the machine precision eps and the smallest edge h of the
cells at a node, the rest is wrong by

- eps, since C - I is a difference of numbers of size one, however small the strain is,
- eps |du|/(2 h), by the increment: a slender body that moves by many times its thickness in a step,

and the strain rate, which viscous stress depends on, by eps |du|/(h dt). A strain makes a force of
h K at a node with stiffness K. Residuals come to rest at 0.2 to 0.6 of the norm of these forces
over two, for all laws, cells, degrees, steps and viscosities that were tried.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array


class ForceRoundOff:
    """The round-off of one body.

    Args:
        edges: Smallest edge h of the cells at each owned node, shape (n_owned,) [m].
        stiffness: Diagonal of half the elastic stiffness, shape (n_owned, 3) [N/m].
        viscosity: Diagonal of the viscous damping matrix, of the same shape [N s/m].
    """

    def __init__(self, edges: Array, stiffness: Array, viscosity: Array) -> None:
        """Scale with the machine precision."""
        half = 0.5 * float(np.finfo(float).eps)
        self._at_rest = half * 2.0 * edges[:, None] * stiffness
        self._stiffness, self._viscosity = half * stiffness, half * viscosity

    def square(self, du: Array, dt: float) -> float:
        """This rank's sum of the squares of the forces' round-off [N^2].

        Args:
            du: Increments of the owned nodes, shape (3 n_owned,) [m].
            dt: Step [s].
        """
        x = du.reshape(-1, 3)
        moved = np.sqrt(np.einsum("ni,ni->n", x, x))[:, None]
        forces = (self._at_rest + moved * (self._stiffness + self._viscosity / dt)).ravel()
        return float(np.dot(forces, forces))


def smallest_edges(space: Any, positions: Array) -> Array:
    """Smallest distance of two nodes of a cell at each local node [m], inf without cells.

    Args:
        positions: Positions of the local nodes, shape (nodes, 3) [m].
    """
    cells = _compat.dofs_of_cells(space)
    X = positions[cells]
    n = X.shape[1]
    pairs = ((i, j) for i in range(n) for j in range(i))
    edges = [np.linalg.norm(X[:, i] - X[:, j], axis=1) for i, j in pairs]
    h = np.full(len(positions), np.inf)
    np.minimum.at(h, cells, np.min(edges, axis=0, initial=np.inf)[:, None])
    return h
