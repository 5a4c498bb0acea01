"""Checks of a reduced body against its mesh and the forces on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.reduced_body import SAME_PLACE, ReducedBody
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.errors import ModelError


def check_mesh(body: ReducedBody, space: Any) -> None:
    """Raise a ModelError if the mesh of the full body is not that of the basis. Collective."""
    points, full = body.basis.points, body.full
    nodes, own = space.dofmap.index_map.size_global, space.dofmap.index_map.size_local
    X = np.vstack([space.tabulate_dof_coordinates()[:own], points[:1]])
    low, high = np.array(full.mesh.comm.allgather([X.min(axis=0), X.max(axis=0)])).swapaxes(0, 1)
    bounds = low.min(axis=0), high.max(axis=0)
    gap = np.max(np.abs(np.array(bounds) - [points.min(axis=0), points.max(axis=0)]))
    if nodes != len(points) or gap > SAME_PLACE * np.max(np.ptp(points, axis=0)):
        raise ModelError(
            f"basis of {body.name!r} belongs to another mesh than full, {full.name!r}: it has "
            f"{len(points)} nodes, and the mesh {nodes}, or another size"
        )


def check_forces(body: ReducedBody, forces: Sequence[object]) -> None:
    """Raise a ModelError for forces that need the mesh, or its masses."""
    for force in forces:
        if isinstance(force, BodyForce) and isinstance(body.full, Carrier):
            raise ModelError(
                f"{force.name!r} acts on the masses of a mesh, and that of {body.name!r} has none: "
                "forces on nodes and sections, and gravity, can act on it"
            )
        if not isinstance(force, NodeForce | BodyForce | SectionLoads):
            raise ModelError(
                f"{getattr(force, 'name', force)!r} acts on the surface of {body.name!r}, which is "
                "reduced: forces on nodes, masses and sections, and gravity, can act on it"
            )
