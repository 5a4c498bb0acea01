"""Forces of fixed directions on the nodes of a body on a mesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.bodies.nearest_node import nearest_node
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.own_code import evaluate_function
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.own_fields import evaluate_field


class NodalForce(NamedTuple):
    """A force as values at nodes.

    Attributes:
        dofs: Its owned degrees of freedom.
        values: Its value for the factor one [N].
    """

    function: Callable[[float], float]
    dofs: slice
    values: Array

    def at(self, comm: MPI.Intracomm, time: float) -> tuple[slice, Array]:
        """Degrees of freedom, and values at a time [s]. Collective."""
        factor = evaluate_function(comm, "factor of a force on nodes", self.function, time)
        return self.dofs, factor * self.values


def find_nodal_forces(
    comm: MPI.Intracomm,
    positions: Array,
    forces: Sequence[NodeForce | BodyForce],
    momentum: Callable[[PETSc.Vec, PETSc.Vec], None],
    field: PETSc.Vec,
) -> list[NodalForce]:
    """Values of forces at the nodes. Collective.

    Args:
        positions: X of the owned nodes, shape (n_owned, 3) [m].
        momentum: Makes M v of nodal values v, into its second argument.
        field: A vector of nodal values for that; it is changed.
    """
    found = []
    for force in forces:
        if isinstance(force, BodyForce):
            what = f"field of {force.name!r}"
            field.array[:] = evaluate_field(comm, what, positions, force.field).ravel()
            momentum(field, field)
            values, dofs = np.array(field.array_r), slice(0, 3 * len(positions))
        else:
            node = nearest_node(comm, positions, force.point)
            dofs = slice(0, 0) if node is None else slice(3 * node, 3 * node + 3)
            values = np.asarray(force.force, dtype=float)[: dofs.stop - dofs.start]
        found.append(NodalForce(force.function, dofs, values))
    return found
