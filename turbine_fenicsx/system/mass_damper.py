"""Damping in proportion to the mass, relative to the surfaces that hold a body.

Three nodes of the mesh of the surface that holds a part move like a rigid frame. With their middle
c, the arms r_k from it and J = sum_k (|r_k|^2 1 - r_k r_k^T),

    omega = J^-1 sum_k r_k x r_k',      w_a = x_a' - h_a c' - omega x (x_a - h_a c),

where h_a is one for nodes that are points and zero for vectors. On the nodes of the part act
f = -alpha M w with their masses M, and on the frame the transpose of its motion, with
F = sum_a h_a f_a and T = sum_a (x_a - h_a c) x f_a

    -F on c,      -(J^-1 T) x r_k on r_k.

Forces and moments add up to zero; the power is -alpha w.M w.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt
from scipy import sparse

from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.owned_nodes import nodes_of_facets
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.section_turns import compile_section_turns

LEAST_WIDTH = 1e-6
"""Least distance of the third node of a frame from the line through the others, relative to that of
these two."""


class DampedPart(NamedTuple):
    """A part of a body that a surface holds.

    Attributes:
        nodes: Owned nodes of the part, shape (k,).
        masses: alpha M of these, shape (k,) if they are lumped, else (k, k) [kg/s].
        frame: Rows of c, r_1, r_2, r_3 over the owned nodes, as of `find_frame`.
    """

    nodes: IntArray
    masses: Array
    frame: sparse.csr_matrix


class Frames(NamedTuple):
    """How the surfaces that hold n parts move.

    Attributes:
        middle: c, shape (n, 3) [m].
        rate: c', shape (n, 3) [m/s].
        arms: r_k, shape (n, 3, 3) [m].
        inverse: J^-1, shape (n, 3, 3) [1/m^2].
        spin: Matrices of omega x, shape (n, 3, 3) [1/s].
    """

    middle: Array
    rate: Array
    arms: Array
    inverse: Array
    spin: Array


class MassDamper:
    """The damping of one body. Collective, also its methods.

    Args:
        model: The body.
        parts: Its parts; nodes of two parts count for both.
    """

    def __init__(self, model: BodyNodes, parts: Sequence[DampedPart]) -> None:
        self._comm, self._X = model.comm, model.positions
        self._turns = compile_section_turns(model.comm)
        self._first = self._comm.scan(len(self._X)) - len(self._X)
        self._h = [model.is_point[part.nodes] for part in parts]
        self._parts = [_as_slice(part.nodes) for part in parts]
        self._masses = [part.masses for part in parts]
        self._frames = [self._gather(part.frame) for part in parts]
        rows = sparse.vstack([part.frame for part in parts], "csc")
        self._own = np.flatnonzero(np.diff(rows.indptr))  # owned nodes of frames
        self._rows = rows[:, self._own].toarray()

    def add_forces(self, u: Array, v: Array, factor: float, out: Array) -> None:
        """Add the forces on the nodes times a factor.

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].
            v: Their velocities, shape (3 n,) [m/s].
            out: What the forces are added to, shape (3 n,).
        """
        x, v, forces = self._X + u.reshape(-1, 3), v.reshape(-1, 3), out.reshape(-1, 3)
        frames = self._find_frames(x, v)
        sums = np.empty((len(self._parts), 4, 3))
        for k, (d, w) in enumerate(self._find_motions(frames, x, v)):
            f = _times(self._masses[k], w)
            f *= factor
            forces[self._parts[k]] += f
            sums[k, 0], sums[k, 1:] = self._h[k] @ f, d.T @ f
        sums = sum_over_ranks(self._comm, sums)
        F, T = sums[:, 0], _axial(sums[:, 1:])
        on_rows = self._turns.find_rows(F, T, frames.arms.swapaxes(1, 2), frames.inverse)
        forces[self._own] -= self._rows.T @ on_rows.reshape(-1, 3)

    def power(self, u: Array, v: Array) -> float:
        """This rank's part of the power that it takes out [W]; arguments as of `add_forces`."""
        x, v = self._X + u.reshape(-1, 3), v.reshape(-1, 3)
        motions = self._find_motions(self._find_frames(x, v), x, v)
        powers = [np.sum(w * _times(M, w)) for (_, w), M in zip(motions, self._masses, strict=True)]
        return float(np.sum(powers))

    def matrix(self, u: Array) -> PETSc.Mat:
        """New matrix of minus the forces per velocity, symmetric [N s/m].

        With alpha M = L L^T and w = Q v it is the sum of Q^T L L^T Q over the parts.

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].
        """
        x, roots = self._X + u.reshape(-1, 3), []
        local, size = 3 * len(x), 3 * self._comm.allreduce(len(x))
        frames = self._find_frames(x, np.zeros_like(x))
        for k, (nodes, h) in enumerate(zip(self._parts, self._h, strict=True)):
            follow = self._follow(frames, k, h, x[nodes] - h[:, None] * frames.middle[k])
            dofs = _dofs(np.arange(len(x))[self._parts[k]])
            if dofs.size:
                columns = 3 * self._first + dofs, _dofs(self._frames[k][0])
                w = _spread(sparse.identity(dofs.size), columns[0], size)
                w -= _spread(sparse.csr_matrix(follow), columns[1], size)
                M = self._masses[k]
                L_T = sparse.diags(np.sqrt(M)) if M.ndim == 1 else _find_root(M)
                roots.append(sparse.kron(L_T, np.eye(3), "csr") @ w)
        root = sparse.vstack(roots, "csr") if roots else sparse.csr_matrix((0, size))
        csr = (root.indptr.astype(PETSc.IntType), root.indices.astype(PETSc.IntType), root.data)
        sizes = ((root.shape[0], None), (local, None))
        root_of_D = PETSc.Mat().createAIJ(sizes, csr=csr, comm=self._comm)
        D = root_of_D.transposeMatMult(root_of_D)
        root_of_D.destroy()
        return D

    def part_matrices(self, u: Array) -> Array:
        """Blocks of `matrix` for equal parts whose own nodes make their frames, with masses (k, k).

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].

        Returns:
            Shape (parts, 3 k, 3 k); nothing where another rank owns the parts.
        """
        x, found = self._X + u.reshape(-1, 3), []
        frames = self._find_frames(x, np.zeros_like(x))
        for k, (M, nodes, h) in enumerate(zip(self._masses, self._parts, self._h, strict=True)):
            d = x[nodes] - h[:, None] * frames.middle[k]
            if len(d):
                first = self._first + np.arange(len(self._X))[nodes][0]
                of_frame = _dofs(self._frames[k][0] - first)
                # w = (1 - C) v on the nodes, where C acts on those of the frame
                C, MC = (self._follow(frames, k, *of) for of in ((h, d), (M @ h, M @ d)))
                D = self._blocks[k].copy()
                D[:, of_frame] -= MC
                D[of_frame] -= MC.T
                D[np.ix_(of_frame, of_frame)] += C.T @ MC
                found.append(D)
        return np.array(found) if found else np.zeros((0, 1, 1))

    @cached_property
    def _blocks(self) -> list[Array]:
        """Masses (k, k) of each part for all directions, shape (3 k, 3 k)."""
        return [np.kron(M, np.eye(3)) for M in self._masses]

    def _find_motions(self, frames: Frames, x: Array, v: Array) -> Iterator[tuple[Array, Array]]:
        """For each part x_a - h_a c, and -w_a, what its nodes lack to move like the frame [m/s]."""
        for k, nodes in enumerate(self._parts):
            h = self._h[k][:, None]
            d = x[nodes] - h * frames.middle[k]
            w = d @ frames.spin[k].T
            w += h * frames.rate[k]
            w -= v[nodes]
            yield d, w

    def _follow(self, frames: Frames, k: int, h: Array, d: Array) -> Array:
        """How c' h + omega x d follows from the rates of the m nodes of a frame, shape (3 n, 3 m).

        Args:
            h: Shape (n,).
            d: Shape (n, 3).
        """
        rows = self._frames[k][1]
        spins = np.einsum("jab,jm->amb", skew_rows(frames.arms[k]), rows[1:])
        # omega = J^-1 sum_k r_k x r_k', omega x d = -d x omega
        turn = -frames.inverse[k] @ spins.reshape(3, -1)
        found: Array = (skew_rows(d) @ turn).reshape(len(d), 3, rows.shape[1], 3)
        for i in range(3):
            found[:, i, :, i] += h[:, None] * rows[0]
        return found.reshape(3 * len(d), 3 * rows.shape[1])

    def _gather(self, frame: sparse.csr_matrix) -> tuple[IntArray, Array]:
        """Nodes of a frame, counted over all ranks, and its rows over these, shape (4, m)."""
        own = np.unique(frame.nonzero()[1])
        found = self._comm.allgather((self._first + own, frame[:, own].toarray()))
        numbers, rows = zip(*found, strict=True)
        return np.concatenate(numbers), np.concatenate(rows, axis=1)

    def _find_frames(self, x: Array, v: Array) -> Frames:
        """How the surfaces move, for positions and velocities of the owned nodes."""
        motion = np.concatenate([x[self._own], v[self._own]], axis=1)
        motion = sum_over_ranks(self._comm, self._rows @ motion).reshape(-1, 4, 6)
        inverse, omega = self._turns.find_spins(motion)
        r = motion[:, 1:, :3]
        return Frames(motion[:, 0, :3], motion[:, 0, 3:], r, inverse, skew_rows(omega))


def find_frame(
    model: BodyNodes, name: str, facets: npt.ArrayLike, copy: int = 0
) -> sparse.csr_matrix:
    """Rows of the frame of a surface, of three nodes that are far from each other. Collective.

    Args:
        model: The body, of whose mesh the facets are.
        name: Name of the damping, for errors.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        copy: Number of the copy.

    Returns:
        Rows of c, r_1, r_2, r_3 over the owned nodes of the body.
    """
    space, comm = model.space, model.comm
    owned = nodes_of_facets(space, check_facets(name, space.mesh, facets))
    X = np.concatenate(comm.allgather(space.tabulate_dof_coordinates()[owned]))
    numbers = np.concatenate(comm.allgather(space.dofmap.index_map.local_range[0] + owned))
    if len(X) < 3:
        raise ModelError(f"a surface of {name!r} has {len(X)} nodes, expected 3 or more")
    order = np.lexsort(np.round(X, 9).T)  # whatever the number of ranks
    X, numbers = X[order], numbers[order]
    a = int(np.linalg.norm(X - X.mean(axis=0), axis=1).argmax())
    b = int(np.linalg.norm(X - X[a], axis=1).argmax())
    along = X[b] - X[a]
    length = float(np.linalg.norm(along))
    widths = np.linalg.norm(np.cross(X - X[a], along), axis=1) / max(length, 1e-300)
    c = int(widths.argmax())
    if widths[c] <= LEAST_WIDTH * length:
        raise ModelError(f"the nodes of a surface of {name!r} must not lie on a line")
    weights = np.vstack([np.full(3, 1.0 / 3.0), np.eye(3) - 1.0 / 3.0])
    return model.rows(copy, numbers[[a, b, c]], weights)


def _axial(A: Array) -> Array:
    """Sums of x x f for sums A of the dyads x f^T, shape (n, 3) for (n, 3, 3)."""
    return np.stack([A[:, j, k] - A[:, k, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)


def _as_slice(nodes: IntArray) -> slice | IntArray:
    """Nodes that follow each other as a slice, which copies nothing."""
    if len(nodes) and nodes[-1] - nodes[0] + 1 == len(nodes):
        return slice(int(nodes[0]), int(nodes[-1]) + 1)
    return nodes


def _dofs(nodes: IntArray) -> IntArray:
    """Degrees of freedom of nodes."""
    dofs: IntArray = (3 * nodes[:, None] + np.arange(3)).ravel()
    return dofs


def _spread(matrix: Any, columns: IntArray, size: int) -> sparse.csr_matrix:
    """Spread the columns of a matrix over those of a wider one."""
    found = matrix.tocoo()
    shape = (found.shape[0], size)
    return sparse.csr_matrix((found.data, (found.row, columns[found.col])), shape=shape)


def _times(masses: Array, w: Array) -> Array:
    """Masses times values of the nodes."""
    return masses[:, None] * w if masses.ndim == 1 else masses @ w


def _find_root(M: Array) -> Array:
    """A matrix L^T with M = L L^T, also of a mass matrix that is singular, as that of a beam."""
    size, V = np.linalg.eigh(M)
    return np.asarray(np.sqrt(np.maximum(size, 0.0))[:, None] * V.T)
