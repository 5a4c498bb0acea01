"""Section motions of a slender body: a coarse space for iterative solvers."""

from __future__ import annotations

from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, hstack, identity, kron

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.flexible_model import FlexibleModel

Indices = npt.NDArray[np.int64]

COARSENING = 4.0
"""Cells of the body for each cell of the lattice across a section."""


def section_motions(flexible: FlexibleModel, nodes: Indices, free: PETSc.IS) -> PETSc.Mat:
    """Interpolation from lattices across the sections of a slender body to its free nodes.

    Sections lie one element apart along the axis of the body, each with a lattice of points some
    elements apart. Between the points of a section a displacement is bilinear, between two sections
    linear. That holds the rigid motions of the sections, a beam, whose soft, long-wave bending and
    torsion local smoothers and algebraic multigrid hardly see, and how sections warp and widen;
    what is left is as short as the elements, however many of them lie across a section.

    Args:
        flexible: The body; its fibres tell the direction, and parts with different directions
            (the blades of a rotor) have sections of their own. Without fibres it is the longest
            axis of inertia.
        nodes: Owned free nodes.
        free: Their degrees of freedom in global numbers.

    Returns:
        Matrix of shape (free degrees of freedom, 3 points of all sections), without points that
        have no nodes near.

    Note:
        Collective.
    """
    comm = flexible.body.mesh.comm
    frames, part, cell_size = _find_parts(flexible, comm)
    part = part[nodes]
    x = np.einsum("nij,nj->ni", frames[part], flexible.positions[nodes])
    low, high = _find_bounds(comm, x[:, 0], part, len(frames))
    n_sections = np.maximum(1, np.ceil((high - low) / cell_size[0] - 1e-6).astype(int)) + 1
    first = np.concatenate([[0], np.cumsum(n_sections)])
    t = np.round((x[:, 0] - low[part]) / (high - low)[part] * (n_sections[part] - 1), 9)
    k = np.minimum(t.astype(int), n_sections[part] - 2)
    ends = first[part] + k, first[part] + k + 1

    twice = np.concatenate([x[:, 1:], x[:, 1:]])
    corner, opposite = _find_bounds(comm, twice, np.concatenate(ends), int(first[-1]))
    widths = opposite - corner
    widest = np.max(widths, axis=0, initial=0.0, where=np.isfinite(widths))
    cells = np.maximum(1, np.ceil(widest / (COARSENING * cell_size[1:]) - 1e-6).astype(int))
    widths = np.maximum(widths, 1e-3 * widest)  # also where a section is a line
    points = cells + 1
    rows, columns, weights = [], [], []
    for section, along in zip(ends, (1.0 - (t - k), t - k), strict=True):
        y = np.round((x[:, 1:] - corner[section]) / widths[section] * cells, 9)
        i = np.clip(y.astype(int), 0, cells - 1)
        y -= i
        for a, b in np.ndindex(2, 2):
            across = np.abs(1 - a - y[:, 0]) * np.abs(1 - b - y[:, 1])
            point = (i[:, 0] + a) * points[1] + i[:, 1] + b
            rows.append(np.arange(len(nodes)))
            columns.append(section * np.prod(points) + point)
            weights.append(along * across)
    entries = np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))
    scalar = csr_matrix(entries, shape=(len(nodes), int(first[-1] * np.prod(points))))
    scalar.eliminate_zeros()
    used = np.bincount(scalar.indices, minlength=scalar.shape[1]) > 0
    comm.Allreduce(MPI.IN_PLACE, used, op=MPI.LOR)
    scalar = scalar[:, used]
    return _in_space(scalar, free.getSize(), comm)


def _in_space(scalar: Any, rows: int, comm: MPI.Intracomm) -> PETSc.Mat:
    """The matrix that interpolates all three directions as one does.

    Args:
        scalar: This rank's rows of the interpolation of one direction.
        rows: Number of rows of the matrix on all ranks.
        comm: Communicator.
    """
    if 3 * scalar.shape[1] == rows:  # PETSc cannot tell a square P from its transpose
        scalar = hstack([scalar, scalar[:, :1]])
    each = kron(scalar, identity(3), format="csr")
    csr = each.indptr.astype(PETSc.IntType), each.indices.astype(PETSc.IntType), each.data
    sizes = (3 * scalar.shape[0], rows), (None, 3 * scalar.shape[1])
    P = PETSc.Mat().createAIJ(sizes, csr=csr, comm=comm)
    P.assemble()
    return P


def _find_parts(flexible: FlexibleModel, comm: MPI.Intracomm) -> tuple[Array, Indices, Array]:
    """Slender parts of a body.

    Returns:
        The directions of each part along and across it, shape (parts, 3, 3), the part of each
        local node, and the mean extents of a cell in these directions, shape (3,) [m].
    """
    cells, X = _compat.dofs_of_cells(flexible.space), flexible.local_positions
    owned = flexible.positions
    directions = flexible.fibre_directions()
    if directions is None:
        everything = np.zeros(len(owned), dtype=np.int64)
        longest = _principal_axes(comm, owned, everything, 1)[0, -1]
        directions = np.broadcast_to(longest, (len(cells), 3))
    rounded = np.round(directions, 6)
    axes = np.unique(np.concatenate(comm.allgather(np.unique(rounded, axis=0))), axis=0)
    part_of_cell = np.argmin(np.linalg.norm(rounded[:, None] - axes, axis=2), axis=1)
    part = np.zeros(len(X), dtype=np.int64)
    part[cells] = part_of_cell[:, None]
    along = np.einsum("ni,ni->n", owned, axes[part[: len(owned)]])
    flat = owned - along[:, None] * axes[part[: len(owned)]]
    across = _principal_axes(comm, flat, part[: len(owned)], len(axes))[:, 1:]
    frames = np.concatenate([axes[:, None], across], axis=1)
    extents = np.ptp(np.einsum("cij,caj->cai", frames[part_of_cell], X[cells]), axis=1)
    total = comm.allreduce(np.append(extents.sum(axis=0), len(extents)))
    return frames, part, total[:3] / total[3]


def _principal_axes(comm: MPI.Intracomm, X: Array, part: Indices, n_parts: int) -> Array:
    """Principal axes of the points of each part, the longest last, shape (parts, 3, 3)."""
    Y = np.column_stack([np.ones(len(X)), X])
    moments = np.zeros((n_parts, 4, 4))
    np.add.at(moments, part, Y[:, :, None] * Y[:, None, :])
    moments = comm.allreduce(moments)
    moments /= np.maximum(moments[:, :1, :1], 1.0)
    mean = moments[:, 0, 1:]
    axes = np.linalg.eigh(moments[:, 1:, 1:] - mean[:, :, None] * mean[:, None, :])[1]
    return np.asarray(np.swapaxes(axes, 1, 2))


def _find_bounds(comm: MPI.Intracomm, x: Array, group: Indices, n: int) -> tuple[Array, Array]:
    """Least and largest x in each of n groups, shape (n, ...); a group of none has inf, -inf."""
    low, high = np.full((n, *x.shape[1:]), np.inf), np.full((n, *x.shape[1:]), -np.inf)
    np.minimum.at(low, group, x)
    np.maximum.at(high, group, x)
    comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return low, high
