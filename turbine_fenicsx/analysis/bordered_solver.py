"""Equations of small motions under the constraints of a system, solved without a basis of them.

A small motion is one flat distributed vector y = (u of each flexible body | q | T). Each rank holds
the displacements that it owns, body after body; rank 0 also holds the coordinates of rigid bodies
and the joint coordinates. With A block by block, one block for each flexible body and one for the
rigid part, and the gradients G of all constraints,

    | A  G^T | | y |   | b |
    | G  0   | | l | = | c |

has the nested form of a step, and its linear solver. Without c constraints stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.mode import Motion
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.nested_blocks import NestedBlocks
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class FlatVectors:
    """Flat vectors of a system's small motions.

    Attributes:
        n_y: Number of coordinates (q, T) of the rigid part.
        local_size: Length of a vector on this rank.
    """

    def __init__(self, system: MultibodySystem) -> None:
        self.system = system
        self.n_y = system.rigid_model.n_q + system.rigid_model.n_T
        sizes = [3 * m.n_owned for m in system.flexible_models]
        self._ends = np.cumsum(sizes, dtype=int).tolist()
        self.local_size = sum(sizes) + (self.n_y if system.comm.rank == 0 else 0)

    def new_vector(self) -> PETSc.Vec:
        """New vector, zero. Collective."""
        vector = PETSc.Vec().create(self.system.comm)
        vector.setSizes((self.local_size, None))
        vector.setType(PETSc.Vec.Type.STANDARD)
        vector.set(0.0)
        return vector

    def split(self, y: PETSc.Vec) -> list[Array]:
        """This rank's part of u of each flexible body, and of (q, T), empty except on rank 0."""
        return np.split(y.array_r, self._ends)

    def split_rows(self, X: Array) -> list[Array]:
        """The same of columns, shape (local_size, k): rows of each body, and of (q, T)."""
        return np.split(X, self._ends)

    def place_of(self, i: int) -> tuple[float, ...]:
        """Key that identifies an entry of this rank among all, on any number of ranks.

        Args:
            i: Number of the entry on this rank.

        Returns:
            Number of the body, initial position of the node, component; for (q, T) the number of
            bodies, then that of the coordinate.
        """
        body = int(np.searchsorted(self._ends, i, side="right"))
        k = i - (self._ends[body - 1] if body else 0)
        if body == len(self._ends):
            return (body, k)
        return (body, *self.system.flexible_models[body].positions[k // 3].tolist(), k % 3)

    def motion(self, y: PETSc.Vec) -> Motion:
        """A vector as the motion of all parts, a copy. Collective."""
        *displacements, r = self.split(y)
        fields = tuple(m.new_vector() for m in self.system.flexible_models)
        for field, values in zip(fields, displacements, strict=True):
            field.array[:] = values
        comm, n_q = self.system.comm, self.system.rigid_model.n_q
        rigid = from_rank0(comm, r.copy() if comm.rank == 0 else np.empty(self.n_y))
        return Motion(rigid[:n_q].copy(), rigid[n_q:].copy(), fields)

    def vector(self, motion: Motion) -> PETSc.Vec:
        """New vector of a motion. Collective."""
        parts = [u.array_r for u in motion.u]
        if self.system.comm.rank == 0:
            parts += [motion.q, motion.joint_coordinates]
        y = self.new_vector()
        y.array[:] = np.concatenate([np.zeros(0), *parts])
        return y

    def block_diagonal(self, flexible: Sequence[PETSc.Mat], rigid: Array) -> PETSc.Mat:
        """Matrix that acts on vectors, by blocks. Collective.

        Args:
            flexible: One block for each flexible body; the matrices themselves, not copies.
            rigid: The block of (q, T), shape (n_y, n_y), read on rank 0.
        """
        comm, k = self.system.comm, len(flexible)
        n = self.n_y if comm.rank == 0 else 0
        R = PETSc.Mat().createDense(((n, self.n_y), (n, self.n_y)), comm=comm)
        R.setUp()
        if n:
            R.getDenseArray()[:] = rigid
        R.assemble()
        blocks: list[list[PETSc.Mat | None]] = [[None] * (k + 1) for _ in range(k + 1)]
        for i, A in enumerate((*flexible, R)):
            blocks[i][i] = A
        matrix = PETSc.Mat().createNest(blocks, comm=comm)
        matrix.setUp()
        matrix.assemble()
        return matrix


def blocks_of(matrix: PETSc.Mat) -> list[PETSc.Mat]:
    """The blocks of a matrix by `FlatVectors.block_diagonal`, the dense one of (q, T) last."""
    n, _ = matrix.getNestSize()
    return [matrix.getNestSubMatrix(i, i) for i in range(n)]


def border(K: Array, G: Array) -> Array:
    """The matrix K with the gradients G of constraints around it.

    Args:
        K: Shape (n, n).
        G: Shape (m, n).

    Returns:
        Shape (n + m, n + m).
    """
    return np.block([[K, G.T], [G, np.zeros((len(G), len(G)))]])


class BorderedSolver(NestedBlocks):
    """Solves A y + G^T l = b, G y = c, with the constraints of a system in a state.

    Args:
        system: The system.
        state: Where the gradients of the constraints are taken.
        matrix: A, by `FlatVectors.block_diagonal`; `factorise` takes its values of the moment.
        prefix: Options prefix of the sparse factorisations.
        symmetric: Whether A is symmetric, which halves work and memory.
    """

    def __init__(
        self,
        system: MultibodySystem,
        state: State,
        matrix: PETSc.Mat,
        prefix: str,
        symmetric: bool = True,
    ) -> None:
        *flexible, self._rigid = blocks_of(matrix)
        super().__init__(system, tuple(flexible))
        self._flat = FlatVectors(system)
        self._G = system.rigid_model.constraint_jacobian(state.q, state.joint_coordinates)
        self._elimination = Elimination(self, prefix, symmetric)
        self._b, self._x = self.new_nested_vector(), self.new_nested_vector()

    @property
    def solves(self) -> int:
        """Number of solutions so far."""
        return self._elimination.krylov_iterations

    def tangent(self, x: PETSc.Vec) -> None:
        """Take the present values of A; x, which linear solvers hand over, is not used."""
        K = self._rigid.getDenseArray() if self.n_r else np.zeros((0, 0))
        self.set_rigid_tangent(border(K, self._G) if self.n_r else K)

    def factorise(self) -> None:
        """Factorise the present values of A. Collective."""
        self._elimination.update(self._x)

    def move(self, coordinate: int, change: float) -> Array:
        """C of a change of the prescribed motion of a joint coordinate.

        Args:
            coordinate: Number of the joint coordinate.
            change: Of it [rad or m].

        Raises:
            ModelError: if none is prescribed.
        """
        column = self._G.shape[1] - self._flat.system.rigid_model.n_T + coordinate
        others = np.any(np.delete(self._G, column, axis=1), axis=1)
        found = np.where(others, 0.0, change * self._G[:, column])
        if not np.any(found):
            name = self._flat.system.joint_coordinate_names[coordinate]
            raise ModelError(f"joint coordinate {name!r} has no prescribed motion")
        return found

    def solve(self, b: PETSc.Vec, y: PETSc.Vec, c: Array | None = None) -> None:
        """Solve for one right-hand side. Collective.

        Args:
            b: Flat vector.
            y: Flat vector, overwritten by the solution.
            c: Changes of the constraints of the rigid part, the same on every rank; zero if None.
        """
        b_u, _, b_r = self.split(self._b)
        *parts, rigid = self._flat.split(b)
        for part, values in zip(b_u, parts, strict=True):
            part.array[:] = values
        if self.n_r:
            b_r.array[: rigid.size] = rigid
            b_r.array[rigid.size :] = 0.0 if c is None else c
        self._elimination.solve(self._b, self._x)
        u, _, r = self.split(self._x)
        parts = [*(part.array_r for part in u), r.array_r[: rigid.size]]
        y.array[:] = np.concatenate(parts)

    def count_negative(self) -> int:
        """Number of negative eigenvalues of A on the motions that the constraints allow.

        Of the symmetric A that was factorised last. Collective.
        """
        return self._elimination.count_negative() - len(self._G)

    def destroy(self) -> None:
        """Free the factors, not the matrix A. Collective."""
        self._elimination.destroy()
        for thing in (self._b, self._x, self.tangent_matrix):
            thing.destroy()
