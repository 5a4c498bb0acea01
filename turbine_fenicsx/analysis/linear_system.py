"""The linear equations of small motions y about a state.

    M y'' + D y' + K y + G^T l = 0,    G y = 0.

K is the Hessian of V + lambda . Phi, the energy and the constraints with their forces lambda; G
holds the gradients of the constraints, which `BorderedSolver` takes care of. M is constant,
because coordinates are positions and directors; joint coordinates have none. D comes from viscous
materials, dampers and forces on surfaces that depend on the velocity.
"""

from __future__ import annotations

from functools import cached_property

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import BorderedSolver, FlatVectors, blocks_of
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


def count_degrees_of_freedom(system: MultibodySystem) -> int:
    """Number of coordinates of a system minus that of independent constraints."""
    sizes = (3 * m.size_global for m in system.flexible_models)
    held = (c.C.getSize()[0] for c in system.coupling_blocks)
    model = system.rigid_model
    return int(sum(sizes) - sum(held)) + 2 * (model.n_q + model.n_T) - model.size


class LinearSystem:
    """Mass, stiffness and damping of a system about a state.

    The matrices act on flat vectors (`FlatVectors`) and consist of one block for each flexible
    body and one for (q, T); `bordered_solver.blocks_of` returns these. Further forces,
    those of a turning frame for example, are added to the blocks.

    Args:
        system: The system.
        state: The state, with the multipliers of its constraint forces; forces and prescribed
            motions are taken at its time. Not changed, and not checked to be an equilibrium.

    Attributes:
        vectors: The flat vectors.
        stiffness: K, unsymmetric if follower forces or pressures are.

    Note:
        Collective.
    """

    def __init__(self, system: MultibodySystem, state: State) -> None:
        self.system, self.state = system, state
        self.vectors = FlatVectors(system)
        flexible = tuple(m.new_stiffness() for m in system.flexible_models)
        for m, K, u in zip(system.flexible_models, flexible, state.u, strict=True):
            m.assemble_stiffness(u, state.time, K)
        rigid = system.rigid_model.stiffness(
            state.q, state.joint_coordinates, state.multipliers, state.time
        )
        self.stiffness = self.vectors.block_diagonal(flexible, rigid)

    @cached_property
    def mass(self) -> PETSc.Mat:
        """M, with zeros for the joint coordinates."""
        model = self.system.rigid_model
        rigid = np.zeros((self.vectors.n_y,) * 2)
        rigid[: model.n_q, : model.n_q] = model.mass_matrix
        flexible = tuple(m.mass_matrix() for m in self.system.flexible_models)
        return self.vectors.block_diagonal(flexible, rigid)

    @cached_property
    def damping(self) -> PETSc.Mat | None:
        """D at rest; None if nothing dampens.

        Raises:
            ModelError: if a force on a surface has no derivative with respect to the velocity at
                rest, like a drag whose absolute value of the velocity is a square root.
        """
        system, state = self.system, self.state
        rigid = system.rigid_model.damping(state.q, state.joint_coordinates, state.time)
        flexible = tuple(
            m.damping_matrix(u, state.time)
            for m, u in zip(system.flexible_models, state.u, strict=True)
        )
        if all(D is None for D in flexible) and not np.any(rigid):
            return None
        for m, D in zip(system.flexible_models, flexible, strict=True):
            if D is not None and not np.isfinite(D.norm()):
                raise ModelError(
                    f"a force on {m.body.name!r} has no derivative with respect to the velocity "
                    "at rest; round off the corner of its law there"
                )
        return self.vectors.block_diagonal(
            [
                zero_matrix(m) if D is None else D
                for m, D in zip(system.flexible_models, flexible, strict=True)
            ],
            rigid,
        )

    def solver(
        self, matrix: PETSc.Mat, prefix: str = "linear_", symmetric: bool = True
    ) -> BorderedSolver:
        """Solver with a matrix, K + mu M for example, under the constraints of the system.

        Args:
            matrix: Combination of the matrices above, block by block.
            prefix: Options prefix of the sparse factorisations.
            symmetric: Whether it is symmetric.
        """
        return BorderedSolver(self.system, self.state, matrix, prefix, symmetric)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of coordinates minus that of independent constraints."""
        return count_degrees_of_freedom(self.system)

    def destroy(self) -> None:
        """Free the matrices. Collective."""
        for name in ("stiffness", "mass", "damping"):
            matrix = self.__dict__.get(name)
            if matrix is not None:
                for block in blocks_of(matrix):
                    block.destroy()
                matrix.destroy()


def quadratic_form(A: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec | None = None) -> float:
    """x.A y, with y = x by default. Collective."""
    product = x.duplicate()
    A.mult(x if y is None else y, product)
    value = float(product.dot(x))
    product.destroy()
    return value


def entry_sizes(vectors: FlatVectors, stiffness: PETSc.Mat) -> PETSc.Vec:
    """New flat vector with the size of the stiffness at each entry of y, for round-off. Collective.

    Of flexible bodies the diagonal; of the rigid part, whose diagonal may be zero, the largest
    entry.
    """
    sizes = vectors.new_vector()
    *flexible, rigid = blocks_of(stiffness)
    diagonals = [K.getDiagonal() for K in flexible]
    largest = np.max(np.abs(rigid.getDenseArray()), initial=0.0)
    n = rigid.getLocalSize()[0]
    sizes.array[:] = np.concatenate([*(d.array_r for d in diagonals), np.full(n, largest)])
    for diagonal in diagonals:
        diagonal.destroy()
    sizes.abs()
    return sizes


def zero_matrix(model: BodyModel) -> PETSc.Mat:
    """Matrix without entries, shaped like the stiffness of a body."""
    n = (3 * model.n_owned, None)
    matrix = PETSc.Mat().createAIJ((n, n), nnz=0, comm=model.comm)
    matrix.setUp()
    matrix.assemble()
    return matrix
