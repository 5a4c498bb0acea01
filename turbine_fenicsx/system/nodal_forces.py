"""Forces of fixed directions on the nodes of a body, however it is discretised."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.own_code import evaluate_function
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.nearest_node import find_nearest_node
from turbine_fenicsx.system.own_fields import evaluate_field


class NodalForce(NamedTuple):
    """A force as values at nodes.

    Attributes:
        dofs: Its owned degrees of freedom.
        values: Its value for the factor one [N].
    """

    name: str
    function: Callable[[float], float]
    dofs: slice
    values: Array

    def at(self, comm: MPI.Intracomm, time: float) -> tuple[slice, Array]:
        """Degrees of freedom, and values at a time [s]. Collective."""
        factor = evaluate_function(comm, f"factor of {self.name!r}", self.function, time)
        return self.dofs, factor * self.values


def find_nodal_forces(
    model: BodyNodes, forces: Sequence[NodeForce | BodyForce]
) -> list[NodalForce]:
    """Each force on the nodes from the first to the last one that it acts on. Collective.

    Raises:
        ModelError: for a field of another shape, or not finite, on all ranks.
    """
    found = []
    for force in forces:
        values = find_nodal_values(model, force)
        nodes = np.flatnonzero(values.any(axis=1))
        first, end = (int(nodes[0]), int(nodes[-1]) + 1) if nodes.size else (0, 0)
        dofs = slice(3 * first, 3 * end)
        found.append(NodalForce(force.name, force.function, dofs, values[first:end].ravel()))
    return found


def find_nodal_values(model: BodyNodes, force: NodeForce | BodyForce) -> Array:
    """Values of a force at the owned nodes for the factor one, shape (n_owned, 3) [N]. Collective.

    Raises:
        ModelError: for a field of another shape, or not finite, on all ranks.
    """
    if isinstance(force, NodeForce):
        _, row = find_nearest_node(model, force.point)
        return np.asarray(row.T @ np.asarray(force.force, dtype=float)[None])
    found, full = np.zeros((model.n_owned, 3)), model.full
    accelerations = full.new_vector()
    for copy, place in enumerate(model.body.placements):
        R, t = place.frame()
        what, points = f"field of {force.name!r}", t + full.positions @ R.T
        accelerations.array[:] = evaluate_field(full.comm, what, points, force.field).ravel()
        full.momentum(accelerations, accelerations)
        found += model.gather_forces(accelerations.array_r.reshape(-1, 3), copy)
    accelerations.destroy()
    return found
