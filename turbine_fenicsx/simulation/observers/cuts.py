"""Sections that cut off the outer parts of slender bodies, and what lies beyond them.

Node a of the mesh lies beyond a section with a share w_a, which rises from 0 to 1 over the length
of the cells that the section cuts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.foundation.parallel import largest_of_ranks
from turbine_fenicsx.foundation.rotations import unit
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.section_turns import Section, find_arms
from turbine_fenicsx.system.body_nodes import BodyNodes

AT_END = 1e-6
"""Smallest distance along a body that counts, over its length."""


@dataclass(frozen=True, eq=False)
class Cut:
    """A section that cuts off the outer part of a body.

    Args:
        section: Where it is; its carrier does not count.
        start: Distance along its axis where the body begins [m].
        end: Where it ends [m].
        point: Point of the moment, fixed to the section; initial position [m], shape (3,).
        axes: Axes of the components, fixed to the section; initial directions as rows, (3, 3).
        beyond: Couplings that hold the part beyond it.
    """

    section: Section
    start: float
    end: float
    point: npt.ArrayLike
    axes: npt.ArrayLike
    beyond: Sequence[Coupling] = ()

    def find_distances(self, points: Array) -> Array:
        """Distances along the axis beyond the section [m], for points where the copy stands."""
        section = self.section
        found: Array = (points - np.asarray(section.origin, dtype=float)) @ unit(section.axis)
        return found - section.distance


def find_shares(model: BodyNodes, cut: Cut) -> Array:
    """w_a of the nodes of the mesh that this rank owns. Collective."""
    (R, t), space = model.body.placements[cut.section.copy].frame(), model.space
    X = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    corners = space.mesh.geometry.x[_compat.nodes_of_cells(space.mesh)]
    d = cut.find_distances(corners.reshape(-1, 3) @ R.T + t).reshape(corners.shape[:2])
    low, high = d.min(axis=1), d.max(axis=1)
    length, distance = cut.end - cut.start, cut.section.distance
    near = AT_END * length
    longest = np.max((high - low)[(low <= near) & (high >= -near)], initial=0.0)
    room = 2.0 * min(distance - cut.start, cut.end - distance)
    width = min(largest_of_ranks(model.comm, float(longest)), room)
    d = cut.find_distances(X @ R.T + t)
    if width <= near:  # all of the body at its start, nothing at its end
        limit = -near if 2.0 * distance < cut.start + cut.end else near
        return np.asarray(d >= limit, dtype=float)
    return np.clip(d / width + 0.5, 0.0, 1.0)


def find_rows(model: BodyNodes, cut: Cut) -> csr_matrix:
    """Rows of centre and B^T of a section. Collective."""
    (R, t), space = model.body.placements[cut.section.copy].frame(), model.space
    X = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    X = t + np.concatenate(model.comm.allgather(X)) @ R.T
    nodes, weights, arms = find_arms(cut.section, X)
    return model.rows(cut.section.copy, nodes, np.vstack([weights, arms.T]))
