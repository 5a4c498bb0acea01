"""Forces on the vectors of a reduced body: those of fixed directions, and those on sections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.forces.body_force import BodyForce
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.section_loads import SectionLoads
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.section_rows import SectionRows


def find_vector_forces(body: ReducedBody, forces: Sequence[NodeForce | BodyForce]) -> list[Array]:
    """Values of each force on all vectors at factor one, shape (copies, n, 3) [N]. Collective."""
    of_masses = _sum_over_mesh(body, [x for x in forces if isinstance(x, BodyForce)])
    return [
        next(of_masses) if isinstance(force, BodyForce) else _find_nearest(body, force)
        for force in forces
    ]


def bind_section_loads(
    body: ReducedBody, loads: Sequence[SectionLoads], positions: Array
) -> tuple[list[SectionRows], tuple[BoundSectionLoads, ...]]:
    """Rows of loads on sections, and the loads with the vectors that they act on. Collective.

    Args:
        positions: Initial values of the vectors that this rank owns, shape (copies n or 0, 3).
    """
    if not loads:
        return [], ()
    model, F = find_functions(body)
    every = np.arange(len(positions))
    rows = [SectionRows(body, model, F, x) for x in loads]
    pairs = zip(loads, rows, strict=True)
    return rows, tuple(BoundSectionLoads(x, own, positions, every, model.comm) for x, own in pairs)


def find_functions(body: ReducedBody) -> tuple[FlexibleModel, Array]:
    """The full body, and the functions at the nodes that this rank owns, shape (n_owned, n)."""
    model = FlexibleModel(body.full)
    return model, body.basis.functions[cKDTree(body.basis.points).query(model.positions)[1]]


def _find_nearest(body: ReducedBody, force: NodeForce) -> Array:
    """A force on the node of any copy that is nearest to its point."""
    points, F = body.points, body.basis.functions
    distance = np.linalg.norm(points - np.asarray(force.point, dtype=float), axis=2)
    copy, node = np.unravel_index(int(np.argmin(distance)), distance.shape)
    values = np.zeros((len(points), F.shape[1], 3))
    values[copy] = np.outer(F[node], np.asarray(force.force, dtype=float))
    return values


def _sum_over_mesh(body: ReducedBody, forces: Sequence[BodyForce]) -> Iterator[Array]:
    """Int rho F_k b dV of fields b, by the forms of the full body."""
    if not forces:
        return
    model, F = find_functions(body)
    for force in forces:
        values = []
        for place in body.placements:
            R, t = (np.asarray(x, dtype=float) for x in (place.rotation, place.position))

            def placed(X: Array, R: Array = R, t: Array = t, force: BodyForce = force) -> Array:
                return force.field(t + X @ R.T)

            (found,) = model.find_nodal_forces([replace(force, field=placed)])
            values.append(F.T @ found.values.reshape(-1, 3))
        yield sum_over_ranks(model.comm, np.array(values))
