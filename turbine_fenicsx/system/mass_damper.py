"""Damping in proportion to the mass, relative to the surfaces that hold a body.

Three nodes k of the surface that holds a part move like a rigid frame: with their middle c, the
arms r_k from it and J = sum_k (|r_k|^2 I - r_k r_k^T),

    v_root(x) = v_c + omega x (x - c),        omega = J^-1 sum_k r_k x v_k.

On each node a of the part acts f_a = -alpha m_a (v_a - v_root(x_a)), and on the three nodes the
transpose of the frame's motion, with F = sum_a f_a and T = sum_a (x_a - c) x f_a

    g_k = -F/3 - (J^-1 T) x r_k.

Forces and moments add up to zero; the power is -alpha sum_a m_a |v_a - v_root(x_a)|^2.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np
from scipy import sparse

from turbine_fenicsx.bodies.facets import check_facets
from turbine_fenicsx.bodies.owned_nodes import nodes_of_cells, nodes_of_facets
from turbine_fenicsx.forces.rayleigh_damping import HeldPart, RayleighDamping
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import cross_rows, skew, skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray

LEAST_WIDTH = 1e-6
"""Least distance of the third node of a frame from the line through the others, relative to that of
these two."""


class Frames(NamedTuple):
    """How the surfaces that hold n parts move; velocities at x are offset + spin x.

    Attributes:
        middle: c, shape (n, 3) [m].
        arms: r_k, shape (n, 3, 3) [m].
        inverse: J^-1, shape (n, 3, 3) [1/m^2].
        spin: Matrices of omega x, shape (n, 3, 3) [1/s].
        offset: v_c - omega x c, shape (n, 3) [m/s].
    """

    middle: Array
    arms: Array
    inverse: Array
    spin: Array
    offset: Array


class MassDamper:
    """The damping of one body. Collective, also its methods.

    Args:
        space: Space of the displacement of the body.
        positions: Initial positions of the owned nodes, shape (n, 3) [m].
        masses: Their masses, positive, shape (n,) [kg].
        damping: With a mass coefficient greater than zero.
    """

    def __init__(
        self, space: Any, positions: Array, masses: Array, damping: RayleighDamping
    ) -> None:
        self._comm, self._X = space.mesh.comm, positions
        self._first = space.dofmap.index_map.local_range[0]
        every = np.arange(len(positions))
        parts = [
            every if part.cells is None else nodes_of_cells(space, part.cells)
            for part in damping.held
        ]
        self._weights = [damping.mass * masses[nodes][:, None] for nodes in parts]
        self._parts = [_as_slice(nodes) for nodes in parts]
        frames = [self._choose_frame(space, damping.name, part) for part in damping.held]
        self._numbers = np.array(frames, dtype=np.int64)  # global numbers of the nodes k
        local = self._numbers - self._first
        self._mine = (local >= 0) & (local < len(positions))
        self._local = local[self._mine]

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
        for k, (nodes, f) in enumerate(self._find_forces(frames, x, v)):
            f *= factor
            forces[nodes] += f
            sums[k, 0], sums[k, 1:] = f.sum(axis=0), x[nodes].T @ f
        sums = sum_over_ranks(self._comm, sums)
        F, T = sums[:, 0], _axial(sums[:, 1:]) - cross_rows(frames.middle, sums[:, 0])
        turns = skew_rows((frames.inverse @ T[:, :, None])[:, :, 0])
        reactions = -F[:, None] / 3.0 - frames.arms @ turns.transpose(0, 2, 1)
        np.add.at(forces, self._local, reactions[self._mine])

    def power(self, u: Array, v: Array) -> float:
        """This rank's part of the power that it takes out [W]; arguments as of `add_forces`."""
        x, v = self._X + u.reshape(-1, 3), v.reshape(-1, 3)
        parts = self._find_forces(self._find_frames(x, v), x, v)
        powers = [
            np.sum(f * f / weights) for (_, f), weights in zip(parts, self._weights, strict=True)
        ]
        return float(np.sum(powers))

    def _find_forces(
        self, frames: Frames, x: Array, v: Array
    ) -> Iterator[tuple[slice | IntArray, Array]]:
        """Nodes of each part, and the forces on them [N]."""
        for k, (nodes, weights) in enumerate(zip(self._parts, self._weights, strict=True)):
            f = x[nodes] @ frames.spin[k].T
            f += frames.offset[k]
            f -= v[nodes]
            f *= weights
            yield nodes, f

    def matrix(self, u: Array) -> PETSc.Mat:
        """New matrix of minus the forces per velocity, symmetric [N s/m].

        With the diagonal W of alpha m_a and the motion Q v of the nodes relative to the frames it
        is Q^T W Q. Nodes of two parts count for both.

        Args:
            u: Displacements of the owned nodes, shape (3 n,) [m].
        """
        x = self._X + u.reshape(-1, 3)
        rows, columns, values = [], [], []
        frames = self._find_frames(x, np.zeros_like(x))
        every = np.arange(len(x))
        for k, (part, weights, numbers) in enumerate(
            zip(self._parts, self._weights, self._numbers, strict=True)
        ):
            nodes = every[part]
            dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
            root = np.sqrt(np.repeat(weights, 3))
            of_frame = (3 * numbers[:, None] + np.arange(3)).ravel()
            d = skew_rows(x[nodes] - frames.middle[k])
            turns = np.hstack([frames.inverse[k] @ skew(r) for r in frames.arms[k]])
            Q = (d @ turns - np.tile(np.eye(3) / 3.0, 3)).reshape(len(dofs), 9)
            rows += [dofs, np.repeat(dofs, 9)]
            columns += [3 * self._first + dofs, np.tile(of_frame, len(dofs))]
            values += [root, (root[:, None] * Q).ravel()]
        entries = tuple(map(np.concatenate, (values, rows, columns)))
        local, size = 3 * len(x), 3 * self._comm.allreduce(len(x))
        found = sparse.coo_matrix((entries[0], entries[1:]), (local, size)).tocsr()
        csr = (found.indptr.astype(PETSc.IntType), found.indices.astype(PETSc.IntType), found.data)
        root_of_D = PETSc.Mat().createAIJ(((local, None), (local, None)), csr=csr, comm=self._comm)
        D = root_of_D.transposeMatMult(root_of_D)
        root_of_D.destroy()
        return D

    def _find_frames(self, x: Array, v: Array) -> Frames:
        """How the surfaces move, for positions and velocities of the owned nodes."""
        values = np.zeros((2, *self._mine.shape, 3))
        values[0, self._mine], values[1, self._mine] = x[self._local], v[self._local]
        points, velocities = sum_over_ranks(self._comm, values)
        middle = points.mean(axis=1)
        r = points - middle[:, None]
        J = -r.transpose(0, 2, 1) @ r
        J += np.einsum("nki,nki->n", r, r)[:, None, None] * np.eye(3)
        inverse = np.linalg.inv(J)
        moments = _axial(r.transpose(0, 2, 1) @ velocities)
        spin = skew_rows((inverse @ moments[:, :, None])[:, :, 0])
        offset = velocities.mean(axis=1) - (spin @ middle[:, :, None])[:, :, 0]
        return Frames(middle, r, inverse, spin, offset)

    def _choose_frame(self, space: Any, name: str, part: HeldPart) -> list[int]:
        """Global numbers of three nodes of a surface that are far from each other."""
        facets = check_facets(name, space.mesh, part.facets)
        owned = nodes_of_facets(space, facets)
        X = np.concatenate(self._comm.allgather(self._X[owned]))
        numbers = np.concatenate(self._comm.allgather(self._first + owned))
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
        return [int(numbers[k]) for k in (a, b, c)]


def _axial(A: Array) -> Array:
    """Sums of x x f for sums A of the dyads x f^T, shape (n, 3) for (n, 3, 3)."""
    return np.stack([A[:, j, k] - A[:, k, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)


def _as_slice(nodes: IntArray) -> slice | IntArray:
    """Nodes that follow each other as a slice, which copies nothing."""
    if len(nodes) and nodes[-1] - nodes[0] + 1 == len(nodes):
        return slice(int(nodes[0]), int(nodes[-1]) + 1)
    return nodes
