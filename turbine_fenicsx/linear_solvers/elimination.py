"""Exact elimination of all flexible bodies, and the equations of the rigid part that are left.

A contact node follows its rigid body, so that its displacement and multiplier drop out of A_uu. Z
is the response of a flexible body to unit motions of its parent bodies, and w that to the forces on
it, see `BodyElimination`. With the motion P of the contact nodes

    (K_r + P^T A_uu Z) r = b_r - P^T (A_uu w - b_u),        u = w + Z r.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.dense import ScaledFactor, count_negative
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.base import DirectSolver
from turbine_fenicsx.linear_solvers.body_elimination import BodyElimination
from turbine_fenicsx.linear_solvers.dense_elimination import DenseElimination
from turbine_fenicsx.linear_solvers.factor import FreeSolver, SparseFactor
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.nested_blocks import NestedBlocks


def make_elimination(
    model: BodyModel,
    tangent: PETSc.Mat,
    coupling: CouplingBlock,
    make_solver: Callable[[PETSc.Mat, PETSc.IS], FreeSolver],
) -> BodyElimination | DenseElimination:
    """The elimination of a body from its tangent, dense if the tangent is.

    Args:
        make_solver: Makes the solver for A_II of a sparse tangent from the matrix and its free
            nodes.
    """
    if "dense" in tangent.getType():
        return DenseElimination(model, tangent, coupling)
    return BodyElimination(model, tangent, coupling, make_solver)


class EliminatedBody(Protocol):
    """A flexible body as the reduced equations see it.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: P^T A_uu Z, shape (columns, columns), equal on all ranks.
    """

    columns: npt.NDArray[np.int64]
    schur: Array

    def eliminate(self, b_u: Array, b_c: Array) -> Array:
        """Compute w, and return P^T (A w - b_u), summed over all ranks."""

    def substitute(self, motion: Array) -> tuple[Array, Array]:
        """Return u and mu_c for the motion r of the parent bodies; after `eliminate`."""


class ReducedEquations:
    """The equations of the rigid part, and the bodies that follow from its motion.

    Attributes:
        matrix: K_r + P^T A_uu Z on rank 0, empty on the others, set by `update`.
    """

    def __init__(self, blocks: NestedBlocks, bodies: Sequence[EliminatedBody]) -> None:
        """Nothing is reduced yet."""
        self._blocks, self._bodies = blocks, bodies
        self.matrix: Array = np.zeros((0, 0))

    def update(self) -> None:
        """Form and factorise the matrix for the present K_r and Schur complements."""
        self.matrix = self._blocks.rigid_tangent.copy()
        if self.matrix.size:
            for body in self._bodies:
                # K_r + P^T A_uu Z
                self.matrix[np.ix_(body.columns, body.columns)] += body.schur
        self._factor = ScaledFactor(self.matrix)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        b_u, b_c, b_r = self._blocks.split(b)
        u, mu_c, r = self._blocks.split(x)
        b_r.copy(r)
        for body, b_u_k, b_c_k in zip(self._bodies, b_u, b_c, strict=True):
            forces = body.eliminate(b_u_k.array_r, b_c_k.array_r)
            if r.array_r.size:
                r.array[body.columns] -= forces
        motion = self._blocks.solve_rigid(self._factor, r)
        for body, u_k, mu_k in zip(self._bodies, u, mu_c, strict=True):
            u_k.array[:], mu_k.array[:] = body.substitute(motion[body.columns])


class Elimination(DirectSolver):
    """Direct solver of the nested tangent, refactorised in each Newton iteration.

    Args:
        blocks: The blocks of the tangent.
        prefix: Options prefix of the sparse factorisations.
        symmetric: Whether the tangent is symmetric, which halves work and memory.
    """

    def __init__(self, blocks: NestedBlocks, prefix: str, symmetric: bool = False) -> None:
        """Set up the eliminations of all flexible bodies."""
        system, kind = blocks.system, SymmetricFactor if symmetric else SparseFactor
        self._blocks = blocks
        self._factors: list[SparseFactor] = []

        def factor(A: PETSc.Mat, free: PETSc.IS) -> FreeSolver:
            self._factors.append(kind(A, f"{prefix}free_"))
            return self._factors[-1]

        self._bodies = [
            make_elimination(m, A, c, factor)
            for m, A, c in zip(
                system.flexible_models, blocks.tangents, system.coupling_blocks, strict=True
            )
        ]
        self._small = [body for body in self._bodies if isinstance(body, DenseElimination)]
        self._reduced = ReducedEquations(blocks, self._bodies)

    def update(self, x: PETSc.Vec) -> None:
        """Factorise A_II of each body at X and form the reduced matrix on rank 0."""
        self._blocks.tangent(x)
        for body in self._bodies:
            body.factorise()
        self._reduced.update()

    def turn(self, x: PETSc.Vec) -> bool:
        """Turn the factors to X where all bodies are small and keep their tangents."""
        turned = self._blocks.turn_tangents(x) if len(self._small) == len(self._bodies) else None
        if turned is None:
            return False
        for body, (Q, lacking) in zip(self._small, turned, strict=True):
            body.turn(Q, lacking)
        if any(Q is not None for Q, _ in turned):
            self._reduced.update()
        return True

    def restore(self, data: RestartData) -> None:
        """Forget the factors, which belong to other tangents."""
        for body in self._small:
            body.forget()

    def count_negative(self) -> int:
        """Number of negative eigenvalues of a symmetric tangent, without the couplings.

        By Sylvester's law, the same as those of all A_II and of the reduced matrix. Independent
        constraints in K_r have one each. Collective; only for what was made as symmetric.
        """
        inner = sum(factor.count_negative() for factor in self._factors)
        comm = self._blocks.system.comm
        return inner + on_rank0(comm, lambda: count_negative(self._reduced.matrix))

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        self.krylov_iterations += 1
        self._reduced.solve(b, x)

    def destroy(self) -> None:
        """Free all PETSc objects."""
        for body in self._bodies:
            body.destroy()
