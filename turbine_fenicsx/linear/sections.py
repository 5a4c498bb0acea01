"""Section motions of a slender body: a coarse space for iterative solvers."""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx import _compat
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.rotations import Array


def section_motions(
    flexible: FlexibleBlock, nodes: npt.NDArray[np.int64], free: PETSc.IS
) -> PETSc.Mat:
    """Interpolation from rigid motions of the sections of a slender body to its free nodes.

    Sections lie one element apart along the axis of the body. Between two of them, a node takes
    the linear interpolation of their rigid motions: three translations and three rotations about
    the centre of the section. That is a beam with rigid sections, which holds the soft, long-wave
    bending and torsion that local smoothers and algebraic multigrid hardly see.

    Args:
        flexible: The body; its fibres tell the direction, and parts with different directions
            (the blades of a rotor) have sections of their own. Without fibres it is the longest
            axis of inertia.
        nodes: Owned free nodes.
        free: Their degrees of freedom in global numbers.

    Returns:
        Matrix of shape (free degrees of freedom, 6 sections).

    Note:
        Collective.
    """
    comm = flexible.body.mesh.comm
    axes, part, spacing = _parts(flexible, comm)
    part = part[nodes]
    X = flexible.positions[nodes]
    s = np.einsum("ni,ni->n", X, axes[part])
    low, high = np.full(len(axes), np.inf), np.full(len(axes), -np.inf)
    np.minimum.at(low, part, s)
    np.maximum.at(high, part, s)
    low, high = np.min(comm.allgather(low), axis=0), np.max(comm.allgather(high), axis=0)
    n_sections = np.maximum(1, np.ceil((high - low) / spacing).astype(int)) + 1
    first = np.concatenate([[0], np.cumsum(n_sections)])
    step = (high - low) / (n_sections - 1)
    t = (s - low[part]) / step[part]
    k = np.minimum(t.astype(int), n_sections[part] - 2)

    centres = _centres(comm, first, part, k, X)
    columns = np.empty((len(nodes), 3, 2, 6), dtype=PETSc.IntType)
    values = np.zeros((len(nodes), 3, 2, 6))
    for end, weight in ((0, 1.0 - (t - k)), (1, t - k)):
        section = first[part] + k + end
        columns[:, :, end] = (6 * section[:, None] + np.arange(6))[:, None, :]
        values[:, :, end] = weight[:, None, None] * rigid_motions(X - centres[section])
    n_rows = 3 * len(nodes)
    indptr = np.arange(0, 12 * n_rows + 1, 12, dtype=PETSc.IntType)
    P = PETSc.Mat().createAIJ(
        ((n_rows, free.getSize()), (None, 6 * int(first[-1]))),
        csr=(indptr, columns.ravel(), values.ravel()),
        comm=comm,
    )
    P.assemble()
    return P


def rigid_motions(x: Array) -> Array:
    """Three translations and three rotations of points x about the origin.

    Args:
        x: Shape (n, 3).

    Returns:
        Shape (n, 3, 6).
    """
    Q = np.zeros((len(x), 3, 6))
    Q[:, :, :3] = np.eye(3)
    for axis in range(3):
        Q[:, :, 3 + axis] = np.cross(np.eye(3)[axis], x)
    return Q


def _parts(
    flexible: FlexibleBlock, comm: MPI.Intracomm
) -> tuple[Array, npt.NDArray[np.int64], float]:
    """Slender parts of a body.

    Returns:
        The directions of the parts, shape (parts, 3), the part of each local node, and the mean
        extent of a cell along its direction [m].
    """
    cells, X = _compat.dofs_of_cells(flexible.space), flexible.local_positions
    directions = flexible.fibre_directions()
    if directions is None:
        Y = np.column_stack([np.ones(flexible.n_owned), flexible.positions])
        moments = comm.allreduce(Y.T @ Y) / comm.allreduce(flexible.n_owned)
        spread = moments[1:, 1:] - np.outer(moments[0, 1:], moments[0, 1:])
        longest = np.linalg.eigh(spread)[1][:, -1]
        directions = np.broadcast_to(longest, (len(cells), 3))
    rounded = np.round(directions, 6)
    axes = np.unique(np.concatenate(comm.allgather(np.unique(rounded, axis=0))), axis=0)
    part_of_cell = np.argmin(np.linalg.norm(rounded[:, None] - axes, axis=2), axis=1)
    part = np.zeros(len(X), dtype=np.int64)
    part[cells] = part_of_cell[:, None]
    extents = np.ptp(np.einsum("cai,ci->ca", X[cells], directions), axis=1)
    return axes, part, float(comm.allreduce(extents.sum()) / comm.allreduce(extents.size))


def _centres(
    comm: MPI.Intracomm,
    first: npt.NDArray[np.int64],
    part: npt.NDArray[np.int64],
    k: npt.NDArray[np.int64],
    X: Array,
) -> Array:
    """Mean position of the nodes next to each section, shape (sections, 3) [m]."""
    n = int(first[-1])
    total, count = np.zeros((n, 3)), np.zeros(n)
    for end in (0, 1):
        section = first[part] + k + end
        count += np.bincount(section, minlength=n)
        for i in range(3):
            total[:, i] += np.bincount(section, X[:, i], minlength=n)
    total, count = comm.allreduce(total), comm.allreduce(count)
    return total / np.maximum(count, 1.0)[:, None]
