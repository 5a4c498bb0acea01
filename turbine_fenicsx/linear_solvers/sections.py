"""Section motions of a slender body: a coarse space for iterative solvers."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix, identity, kron
from scipy.special import eval_legendre

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.cell_centres import CellCentres
from turbine_fenicsx.system.flexible_model import FlexibleModel

Indices = npt.NDArray[np.int64]

CELLS = 3.0
"""Cells across a section for each degree of its polynomials, so that what they leave to the
smoother is as short as some cells, however many there are."""

LEAST, MOST = 2, 5
"""Degrees of the polynomials: a bent section widens and narrows by squares (Poisson's ratio), and
the factor of the coarse problem is on each rank, 50 kB for a section of degree 5."""


def section_motions(flexible: FlexibleModel, nodes: Indices) -> PETSc.Mat:
    """Interpolation from motions of the sections of a slender body to its free nodes. Collective.

    Sections lie one element apart along the axis of the body. In each a displacement is a
    polynomial of the coordinates across, between two sections linear. That holds the rigid motions
    of the sections, a beam, whose soft, long-wave bending and torsion local smoothers and algebraic
    multigrid hardly see, and how sections shear, warp and widen when they bend. The degree follows
    the number of cells across. The sections belong to the rank that has most of their nodes.

    Args:
        flexible: The body; its fibres define the direction, and parts with different directions
            (the blades of a rotor) have separate sections. Without fibres it is the longest
            axis of inertia.
        nodes: Owned free nodes.

    Returns:
        Matrix of shape (free degrees of freedom, m sections), without sections that have no nodes
        near; m is 18, 30, 45 or 63 for degrees 2 to 5.
    """
    comm = flexible.body.mesh.comm
    frames, part, cell = _find_parts(flexible, comm)
    part = part[nodes]
    x = np.einsum("nij,nj->ni", frames[part], flexible.positions[nodes])
    low, high = _find_bounds(comm, x[:, 0], part, len(frames))
    n_sections = np.maximum(1, np.ceil((high - low) / cell[0] - 1e-6).astype(int)) + 1
    first = np.concatenate([[0], np.cumsum(n_sections)])
    t = np.round((x[:, 0] - low[part]) / (high - low)[part] * (n_sections[part] - 1), 9)
    k = np.minimum(t.astype(int), n_sections[part] - 2)
    before = first[part] + k
    weights = np.stack([1.0 - (t - k), t - k])
    near = np.stack([before, before + 1])[weights > 0.0]
    node = np.nonzero(weights > 0.0)[1]

    low, high = _find_bounds(comm, x[node, 1:], near, int(first[-1]))
    any_near = np.isfinite(low[:, 0])
    low, high = (np.where(any_near[:, None], x, 0.0) for x in (low, high))
    middle, radius = 0.5 * (low + high), 0.5 * (high - low)
    cells = 2.0 * np.mean(radius[any_near], axis=0) / cell[1:]
    degrees = np.clip(np.ceil(cells / CELLS - 1e-3), LEAST, MOST).astype(np.int64)
    radius = np.maximum(radius, 1e-3 * np.max(radius, axis=0))  # also where a section is a line
    y = (x[node, 1:] - middle[near]) / radius[near]
    values = _evaluate_polynomials(y, degrees) * weights[weights > 0.0][:, None]
    number, own = _number_by_owner(comm, near, int(first[-1]))
    m = values.shape[1]
    columns = number[near][:, None] * m + np.arange(m)
    shape = len(nodes), (number.max(initial=-1) + 1) * m
    scalar = csr_matrix((values.ravel(), (np.repeat(node, m), columns.ravel())), shape)
    each = kron(scalar, identity(3), format="csr")
    csr = each.indptr.astype(PETSc.IntType), each.indices.astype(PETSc.IntType), each.data
    sizes = (each.shape[0], None), (3 * m * own, each.shape[1])
    P = PETSc.Mat().createAIJ(sizes, csr=csr, comm=comm)
    P.assemble()
    return P


def _evaluate_polynomials(y: Array, degrees: Indices) -> Array:
    """Products of Legendre polynomials in points y of [-1, 1]^2, shape (points, m).

    With degrees d_1, d_2 those of degrees i, j with i/d_1 + j/d_2 <= 1: all of the lower degree.
    """
    i, j = np.indices(tuple(degrees + 1)).reshape(2, -1)
    chosen = i * degrees[1] + j * degrees[0] <= np.prod(degrees)
    found: Array = eval_legendre(i[chosen], y[:, :1]) * eval_legendre(j[chosen], y[:, 1:])
    return found


def _number_by_owner(comm: MPI.Intracomm, near: Indices, n: int) -> tuple[Indices, int]:
    """Numbers of n sections, those of a rank next to each other, -1 where there are no nodes near.

    Args:
        near: The section of each pair of an owned node with a section near.
        n: Number of sections.

    Returns:
        The numbers, and how many sections belong to this rank: those of which it has most nodes.
    """
    mine = np.bincount(near, minlength=n)
    most, owner = np.empty_like(mine), np.empty_like(mine)
    comm.Allreduce(mine, most, op=MPI.MAX)
    comm.Allreduce(np.where(mine == most, comm.rank, comm.size), owner, op=MPI.MIN)
    used = np.flatnonzero(most)
    number = np.full(n, -1)
    number[used[np.argsort(owner[used], kind="stable")]] = np.arange(used.size)
    return number, int(np.count_nonzero(owner[used] == comm.rank))


def _find_parts(flexible: FlexibleModel, comm: MPI.Intracomm) -> tuple[Array, Indices, Array]:
    """Slender parts of a body.

    Returns:
        The directions of each part along and across it, shape (parts, 3, 3), the part of each
        local node, and the mean extents of a cell in these directions, shape (3,) [m].
    """
    cells, X = _compat.dofs_of_cells(flexible.space), flexible.local_positions
    owned = flexible.positions
    directions = CellCentres(flexible).fibres()
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
