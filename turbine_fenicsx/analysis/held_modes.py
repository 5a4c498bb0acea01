"""Modes of a part of a flexible body that is held, whatever else the system does.

The nodes of the surface that holds the part do not move. At its other end a rigid body may sit: its
six coordinates r, displacement and small rotation of a point p, move the nodes x of a surface by

    u = r_1..3 + r_4..6 x (x - p).

A part that is stretched by its rotation has the stiffness K(u) in the displacements u of its
equilibrium. Under a weight f, which bends little, K is linear in the u that f causes:

    K_f = K(0) + [K(e u) - K(-e u)]/(2 e).

A linear u has no true strains of second order, so that K(u) itself would be wrong. In blades that
turn the walls buckle in this linear picture, at loads under which they do not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
from scipy import sparse

from turbine_fenicsx.analysis.lowest_modes import find_lowest_modes
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import skew, skew_rows
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.linear_solvers.factor import to_petsc
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.flexible_model import FlexibleModel

SMALL = 0.1
"""The factor e of displacements. Quadratic laws have an exact derivative with any, and round-off
grows with 1/e."""


@dataclass(frozen=True, eq=False)
class Rider:
    """A rigid body at the end of a part.

    Args:
        nodes: Owned nodes of the surface on which it sits, shape (n,).
        point: The point p, shape (3,) [m].
        mass: Mass matrix of its six coordinates, shape (6, 6).
        stiffness: Stiffness of its weight, of the same shape.
        load: Its weight as force and moment about p, shape (6,) [N, N m].
    """

    nodes: IntArray
    point: Array
    mass: Array
    stiffness: Array
    load: Array

    @classmethod
    def of(cls, nodes: IntArray, point: Array, inertia: Array, gravity: Array) -> Rider:
        """The rider with mass, first and second moments about a point.

        Args:
            inertia: Sums of m, m r and m r r^T over all that sits there, r from the point, as the
                matrix [[m, m r^T], [m r, m r r^T]], shape (4, 4).
            gravity: Acceleration, shape (3,) [m/s^2].
        """
        m, s, E = inertia[0, 0], inertia[0, 1:], inertia[1:, 1:]
        M, K = np.zeros((6, 6)), np.zeros((6, 6))
        M[:3, :3], M[3:, 3:] = m * np.eye(3), np.trace(E) * np.eye(3) - E
        M[:3, 3:], M[3:, :3] = -skew(s), skew(s)
        # second-order work of the weight, g . [th]^2 s/2
        outer = np.outer(gravity, s)
        K[3:, 3:] = (gravity @ s) * np.eye(3) - 0.5 * (outer + outer.T)
        return cls(nodes, point, M, K, np.concatenate([m * gravity, np.cross(s, gravity)]))


@dataclass(frozen=True, eq=False)
class HeldMode:
    """A mode with the modal mass 1.

    Args:
        frequency: Angular frequency [rad/s].
        shape: Displacement of all owned nodes of the body, zero beside the part, shape (n, 3).
        strain: u^T K(0) u, twice the strain energy of the elastic body at rest [1/s^2].
    """

    frequency: float
    shape: Array
    strain: float


def held_modes(
    model: FlexibleModel,
    nodes: IntArray,
    held: IntArray,
    count: int,
    *,
    load: PETSc.Vec | None = None,
    displacement: Array | None = None,
    spin: Array | None = None,
    rider: Rider | None = None,
) -> list[HeldMode]:
    """Modes of a part of a flexible body, the lowest first, without damping. Collective.

    Args:
        nodes: Owned nodes of the part, shape (n,).
        held: Those of them that do not move.
        count: Number of modes; fewer come if the part has not as many.
        load: Forces on the nodes that prestress it [N].
        displacement: In place of a load, displacements of all owned nodes of the body in an
            equilibrium, shape (n_owned, 3) [m].
        spin: Matrix S of a rotation omega x, which adds M S^2 to the stiffness, shape (3, 3).
    """
    part = _Part(model, nodes, held, rider)
    u = model.new_vector()
    K0 = part.reduce(lambda K: model.assemble_stiffness(u, 0.0, K), part.rider_stiffness)
    K, M = K0, part.reduce(lambda M: model.add_mass(np.eye(3), M), part.rider_mass)
    forces = part.forces(load)
    if displacement is not None:
        u.array[:] = displacement.ravel()
        K = part.reduce(lambda K: model.assemble_stiffness(u, 0.0, K), part.rider_stiffness)
    elif forces.any():
        moved = part.expand(on_rank0(part.comm, lambda: _solve(K0, forces)))
        for sign in (1.0, -1.0):
            u.array[:] = sign * SMALL * moved.ravel()
            stiffness = part.reduce(lambda K: model.assemble_stiffness(u, 0.0, K), None)
            K = K + sign / (2.0 * SMALL) * stiffness
    if spin is not None:
        K = K + part.reduce(lambda M: model.add_mass(spin @ spin, M), None)
    u.destroy()
    K0 = K0 - part.pad(part.rider_stiffness)
    squares, shapes = on_rank0(part.comm, lambda: _find(K, M, count))
    return [
        HeldMode(float(np.sqrt(square)), part.expand(shape), float(shape @ (K0 @ shape)))
        for square, shape in zip(squares, shapes.T, strict=True)
    ]


class _Part:
    """The free coordinates of a part: its free nodes on all ranks, then those of a rider."""

    def __init__(
        self, model: FlexibleModel, nodes: IntArray, held: IntArray, rider: Rider | None
    ) -> None:
        self._model, self.comm = model, model.body.mesh.comm
        on_rider = np.zeros(0, np.int64) if rider is None else rider.nodes
        self._free = np.setdiff1d(nodes, np.concatenate([held, on_rider]))
        self._moved = np.concatenate([self._free, on_rider])
        counts = self.comm.allgather(len(self._free))
        self._first, n = sum(counts[: self.comm.rank]), sum(counts)
        self.rider_mass = self.rider_stiffness = None
        self._load, arms = np.zeros(0), np.zeros((0, 3, 6))
        if rider is not None:
            self.rider_mass, self.rider_stiffness = rider.mass, rider.stiffness
            self._load = rider.load
            r = model.positions[on_rider] - rider.point
            arms = np.concatenate([np.tile(np.eye(3), (len(r), 1, 1)), -skew_rows(r)], axis=2)
        self._size = 3 * n + self._load.size
        free, k = 3 * len(self._free), self._load.size
        rows = [np.arange(free), free + np.repeat(np.arange(3 * len(on_rider)), k)]
        columns = [3 * self._first + np.arange(free)]
        columns.append(np.tile(3 * n + np.arange(k), 3 * len(on_rider)))
        values = np.concatenate([np.ones(free), arms.ravel()])
        entries = values, (np.concatenate(rows), np.concatenate(columns))
        self._own = sparse.csr_matrix(entries, (3 * len(self._moved), self._size))
        self._all = sparse.vstack(self.comm.allgather(self._own), "csr")

    def reduce(
        self, assemble: Callable[[PETSc.Mat], None], of_rider: Array | None
    ) -> sparse.csr_matrix:
        """T^T A T of a matrix of the body and what a rider adds, on every rank."""
        full = self._model.new_stiffness()
        assemble(full)
        first = 3 * self._model.space.dofmap.index_map.local_range[0]
        dofs = (first + 3 * self._moved[:, None] + np.arange(3)).ravel().astype(PETSc.IntType)
        rows = PETSc.IS().createGeneral(dofs, comm=self.comm)
        matrix = full.createSubMatrix(rows, rows)
        starts, columns, values = matrix.getValuesCSR()
        own = sparse.csr_matrix((values, columns, starts), (dofs.size, self._all.shape[0]))
        gathered = sparse.vstack(self.comm.allgather(own), "csr")
        for each in (full, matrix, rows):
            each.destroy()
        found = self._all.T @ gathered @ self._all + self.pad(of_rider)
        return sparse.csr_matrix(0.5 * (found + found.T))

    def pad(self, of_rider: Array | None) -> sparse.csr_matrix:
        """A matrix of the rider among zeros."""
        if of_rider is None:
            return sparse.csr_matrix((self._size, self._size))
        n = self._size - len(of_rider)
        return sparse.block_diag([sparse.csr_matrix((n, n)), of_rider], "csr")

    def forces(self, load: PETSc.Vec | None) -> Array:
        """Forces on the coordinates, on every rank."""
        found = np.concatenate([np.zeros(self._size - self._load.size), self._load])
        if load is not None:
            own = self._own.T @ load.array_r.reshape(-1, 3)[self._moved].ravel()
            found += np.sum(self.comm.allgather(own), axis=0)
        return found

    def expand(self, coordinates: Array) -> Array:
        """Displacements of all owned nodes of the body, shape (n, 3)."""
        found = np.zeros((self._model.n_owned, 3))
        found[self._moved] = (self._own @ coordinates).reshape(-1, 3)
        return found


def _solve(K: sparse.csr_matrix, forces: Array) -> Array:
    """Displacements under forces."""
    with one_thread(), _factor(K) as solve:
        return solve(forces)


def _find(K: sparse.csr_matrix, M: sparse.csr_matrix, count: int) -> tuple[Array, Array]:
    """The lowest squares of angular frequencies, and their vectors in columns."""
    count = min(count, K.shape[0] - 1)  # more are not found by iteration
    if count < 1:
        raise ModelError("a part without free nodes has no modes")
    with one_thread(), _factor(K) as solve:
        return find_lowest_modes(K, M, count, solve)


@contextmanager
def _factor(K: sparse.csr_matrix) -> Iterator[Callable[[Array], Array]]:
    """A function that solves with a symmetric matrix of this rank."""
    matrix = to_petsc(K)
    factor = SymmetricFactor(matrix, "held_modes_")
    factor.update()
    try:
        yield lambda forces: factor.solve_many(forces[:, None])[:, 0]
    finally:
        factor.destroy()
        matrix.destroy()
