"""Forces of fixed directions on the vectors of a reduced body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_nodes import BodyNodes


def find_vector_forces(
    body: ReducedBody,
    model: BodyNodes,
    find_functions: Callable[[], Array],
    forces: Sequence[NodeForce | BodyForce],
) -> list[Array]:
    """Values of each force on all vectors at factor one, shape (copies, n, 3) [N]. Collective.

    Args:
        find_functions: Gives the functions at the nodes of the mesh that this rank owns.
    """
    return [
        _sum_over_mesh(model, find_functions(), force)
        if isinstance(force, BodyForce)
        else _find_nearest(body, force)
        for force in forces
    ]


def _find_nearest(body: ReducedBody, force: NodeForce) -> Array:
    """A force on the node of any copy that is nearest to its point."""
    points, F = body.points, body.basis.functions
    distance = np.linalg.norm(points - np.asarray(force.point, dtype=float), axis=2)
    copy, node = np.unravel_index(int(np.argmin(distance)), distance.shape)
    values = np.zeros((len(points), F.shape[1], 3))
    values[copy] = np.outer(F[node], np.asarray(force.force, dtype=float))
    return values


def _sum_over_mesh(model: BodyNodes, functions: Array, force: BodyForce) -> Array:
    """Int rho F_k b dV of a field b, by the forms of the full body."""
    values = []
    for place in model.body.placements:
        R, t = place.frame()

        def placed(X: Array, R: Array = R, t: Array = t) -> Array:
            return force.field(t + X @ R.T)

        (found,) = model.full.find_nodal_forces([replace(force, field=placed)])
        values.append(functions.T @ found.values.reshape(-1, 3))
    return sum_over_ranks(model.comm, np.array(values))
