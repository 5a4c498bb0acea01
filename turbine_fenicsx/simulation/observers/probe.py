"""Weighted sums of points and vectors of bodies: a matrix on the state, and nothing else.

With the nodes x_k of all deformable bodies, and the points phi and directors d_i of all rigid
bodies, a row gives y = sum_k w_k x_k. The matrix is made once; in a run each rank adds up what its
own nodes contribute. Points, tips, gauges and sections all read a probe.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, vstack

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.material_points import find_surroundings
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.nearest_node import find_nearest_node
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

Rows: TypeAlias = tuple[RigidBody | DeformableBody, csr_matrix]
"""Sums of one body: weights of its nodes as of `BodyNodes.rows`, or of phi, d_1, d_2, d_3."""


class Probe:
    """The matrix of some sums.

    Args:
        system: The system.
        sums: The sums, one body after another; a body may come again.

    Attributes:
        start: The sums of deformable bodies in the initial configuration, zero for rigid ones,
            shape (n, 3).

    Note:
        Collective, as are all methods.
    """

    def __init__(self, system: MultibodySystem, sums: Sequence[Rows]) -> None:
        self._comm = system.comm
        ends = np.cumsum([0, *(rows.shape[0] for _, rows in sums)])

        def stack(bodies: Sequence[object]) -> list[tuple[int, npt.NDArray[np.int64], csr_matrix]]:
            """Numbers of the bodies with sums, places of the sums, and their rows."""
            found = []
            for k, body in enumerate(bodies):
                mine = [j for j, (other, _) in enumerate(sums) if other is body]
                if mine:
                    places = np.concatenate([np.arange(ends[j], ends[j + 1]) for j in mine])
                    found.append((k, places, vstack([sums[j][1] for j in mine], "csr")))
            return found

        self._rigid, self._nodal = stack(system.rigid_bodies), stack(system.flexible_bodies)
        start = np.zeros((ends[-1], 3))
        for k, places, rows in self._nodal:
            start[places] = rows @ system.flexible_models[k].positions
        self.start: Array = sum_over_ranks(self._comm, start)

    def values(self, state: State) -> Array:
        """The sums at a state, shape (n, 3), equal on all ranks."""
        return self.start + sum_over_ranks(self._comm, self._add_up(state.q, state.u))

    def motion(self, state: State) -> Array:
        """The sums at a state, and their rates, shape (n, 2, 3), equal on all ranks."""
        pairs = ((state.q, state.u), (state.q_dot, state.v))
        found = sum_over_ranks(self._comm, np.stack([self._add_up(*p) for p in pairs], axis=1))
        found[:, 0] += self.start
        return found

    def _add_up(self, q: Array, nodal: Sequence[PETSc.Vec]) -> Array:
        """Sums over the nodes of this rank, shape (n, 3); rank 0 adds rigid bodies."""
        found = np.zeros_like(self.start)
        for k, places, rows in self._nodal:
            found[places] = rows @ nodal[k].array_r.reshape(-1, 3)
        if self._comm.rank == 0:
            for k, places, rows in self._rigid:
                found[places] = rows @ q.reshape(-1, 4, 3)[k]
        return found


def find_model(system: MultibodySystem, body: DeformableBody, whose: str) -> BodyNodes:
    """The model of a body, which must be among the parts of the system.

    Args:
        whose: What asks for it, for the error.
    """
    check_among_parts("body", body, system.flexible_bodies, whose)
    return system.flexible_models[system.flexible_bodies.index(body)]


def find_point(model: BodyNodes, point: Array, name: str) -> csr_matrix:
    """Row of a material point of any copy of a body. Collective.

    Args:
        point: In the initial configuration, shape (3,) [m].
        name: Name of the point, for the error.
    """
    places = [place.frame() for place in model.body.placements]
    for copy, (R, t) in enumerate(places):
        found = find_surroundings(model.space, (point - t) @ R)
        if found is not None:
            return model.rows(copy, found.nodes, found.functions)
    nearest, _ = find_nearest_node(model, point)
    raise ModelError(
        f"point {name!r} at {point.tolist()} is outside flexible body {model.body.name!r}, whose "
        f"nearest node is {nearest:.3g} m away"
    )
