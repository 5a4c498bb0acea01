"""Numbers by which a basis knows the body that it was made of."""

from __future__ import annotations

from typing import Any

from mpi4py import MPI

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import SAME_PLACE, ReducedBasis
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.cell_fields import is_field
from turbine_fenicsx.reduction.elasticity import Law
from turbine_fenicsx.system.mesh_areas import positions_of
from turbine_fenicsx.system.quadrature import stress_rule

EQUAL = 1e-9
"""Relative difference of numbers that are equal but for round-off."""


def describe_cells(body: FlexibleBody, law: Law) -> Array:
    """Middle, volume, density, and sums of stiffness and viscosity of each cell. Collective.

    Returns:
        Shape (cells, 7), of all ranks.
    """
    rows, error = np.zeros((0, 7)), None
    try:
        rows = _describe_own(body, law)
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(body.mesh.comm, error)
    found: Array = np.concatenate(body.mesh.comm.allgather(rows))
    return found


def _describe_own(body: FlexibleBody, law: Law) -> Array:
    """The rows of the cells that this rank owns."""
    points, weights = stress_rule(body)
    cells = np.arange(body.mesh.topology.index_map(3).size_local)
    at = law.tabulate(cells, points[0])
    # weights that tell the entries of a matrix apart, and the points of the rule
    of_entries = 1.0 + np.random.default_rng(0).random((6, 6))
    of_rule = float(np.sum(weights[:, None] * (1.0 + points) ** 2 * [1.0, 1.3, 1.7]))
    stiffness = of_rule * np.sum(at.stiffness * of_entries, axis=(1, 2))
    viscosity = np.zeros(len(cells))
    if at.viscosity is not None:
        viscosity = np.sum(at.viscosity * of_entries, axis=(1, 2))
    corners = body.mesh.geometry.x[_compat.nodes_of_cells(body.mesh)[cells]]
    volume = np.abs(np.linalg.det(at.jacobians))
    density = np.full(len(cells), np.nan)
    if is_field(body.density):
        density = body.density.x.array[: len(cells)]
    else:
        density[:] = np.asarray(body.density, dtype=float)
    return np.column_stack([corners.mean(axis=1), volume, density, stiffness, viscosity])


def find_difference(basis: ReducedBasis, cells: Array, nodes: int) -> str:
    """How a body differs from that of a basis, a clause; empty if it does not.

    Args:
        cells: Numbers of the cells of the body, as of `describe_cells`.
        nodes: Number of nodes of its displacement.
    """
    if len(cells) != len(basis.cells):
        return f"the mesh has {len(cells)} cells, and that of the basis {len(basis.cells)}"
    if nodes != len(basis.points):
        return f"the mesh has {nodes} nodes, and that of the basis {len(basis.points)}"
    size = float(np.max(np.ptp(basis.points, axis=0)))
    distance, order = cKDTree(basis.cells[:, :3]).query(cells[:, :3])
    if np.max(distance) > SAME_PLACE * size or np.unique(order).size < len(order):
        return "the cells of the mesh stand elsewhere"
    stored = basis.cells[order]
    for column, word in enumerate(("volume", "density", "stiffness", "viscosity"), start=3):
        a, b = cells[:, column], stored[:, column]
        if np.max(np.abs(a - b)) > EQUAL * max(np.max(np.abs(a)), np.max(np.abs(b))):
            return f"the cells have another {word}"
    return ""


def find_other_nodes(basis: ReducedBasis, comm: MPI.Intracomm, space: Any) -> str:
    """How a mesh differs from that of a basis without cells, a clause; empty if it does not.

    Args:
        comm: Communicator of the mesh.
        space: Space of its displacement.
    """
    points = np.concatenate(comm.allgather(positions_of(space)))
    if len(points) != len(basis.points):
        return f"the mesh has {len(points)} nodes, and that of the basis {len(basis.points)}"
    size = float(np.max(np.ptp(basis.points, axis=0)))
    if np.max(cKDTree(basis.points).query(points)[0]) > SAME_PLACE * size:
        return "the nodes of the mesh stand elsewhere"
    return ""
