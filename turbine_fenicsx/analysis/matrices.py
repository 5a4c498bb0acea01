"""The matrices of a system about a state as SciPy's sparse matrices: for control, reduction, study.

Small motions y about a state obey, with the gradients G of all constraints and their forces l,

    M y'' + D y' + K y + G^T l = 0,    G y = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from scipy import sparse

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True)
class SystemMatrices:
    """Matrices of a system about a state, whole on each rank.

    The unknowns y are the displacements of each flexible body, node by node, then the coordinates q
    (center of mass and directors) of the rigid bodies, then the joint coordinates T. Their order
    within a flexible body depends on the number of ranks.

    Args:
        mass: M, shape (n, n) [kg]; zero for the joint coordinates.
        damping: D, shape (n, n) [N s/m]: viscosity, dampers, forces that depend on velocities.
        stiffness: K, shape (n, n) [N/m]: the Hessian of energy and constraints with their forces.
        constraints: G, shape (m, n): rows of rigid bodies and joints, of joint coordinates, of
            relations, then those of the couplings, C u + B q.
        parts: Unknowns of each flexible body by name, of "rigid bodies" and "joint coordinates".
    """

    mass: sparse.csr_matrix
    damping: sparse.csr_matrix
    stiffness: sparse.csr_matrix
    constraints: sparse.csr_matrix
    parts: dict[str, slice]

    def __repr__(self) -> str:
        """Sizes in one line."""
        m, n = self.constraints.shape
        return f"SystemMatrices({n} unknowns, {m} constraints, parts {', '.join(self.parts)})"


def system_matrices(system: MultibodySystem, state: State | None = None) -> SystemMatrices:
    """Mass, damping, stiffness and constraints of a system about a state.

    They are gathered on every rank; for distributed ones see
    `turbine_fenicsx.analysis.linear_system.LinearSystem`. Velocities of the state count as zero.

    Args:
        system: The system.
        state: Where to linearise, with the multipliers of its constraint forces; forces are taken
            at its time. The initial state if None.

    Raises:
        ModelError: if a force on a surface has no derivative with respect to the velocity at rest.

    Note:
        Collective.
    """
    state = system.initial_state() if state is None else state
    linear = LinearSystem(system, state)
    try:
        sizes = [block.getSize()[0] for block in blocks_of(linear.mass)]
        n = sum(sizes)
        no_damping = sparse.csr_matrix((n, n))
        return SystemMatrices(
            mass=_gather_diagonal(linear.mass),
            damping=no_damping if linear.damping is None else _gather_diagonal(linear.damping),
            stiffness=_gather_diagonal(linear.stiffness),
            constraints=_gather_constraints(system, state, sizes),
            parts=_name_parts(system, sizes),
        )
    finally:
        linear.destroy()


def _name_parts(system: MultibodySystem, sizes: list[int]) -> dict[str, slice]:
    """Where the unknowns of each part stand."""
    model, ends = system.rigid_model, np.cumsum(sizes).tolist()
    names = [m.body.name for m in system.flexible_models]
    parts = {k: slice(e - s, e) for k, e, s in zip(names, ends, sizes[:-1], strict=False)}
    q = ends[-1] - model.n_q - model.n_T
    return {
        **parts,
        "rigid bodies": slice(q, q + model.n_q),
        "joint coordinates": slice(q + model.n_q, ends[-1]),
    }


def _gather(matrix: PETSc.Mat) -> sparse.csr_matrix:
    """A distributed matrix on every rank. Collective."""
    comm: MPI.Intracomm = matrix.comm.tompi4py()
    if matrix.type.endswith("dense"):
        rows = sparse.csr_matrix(matrix.getDenseArray())
    else:
        starts, columns, values = matrix.getValuesCSR()
        shape = (starts.size - 1, matrix.getSize()[1])
        rows = sparse.csr_matrix((values, columns, starts), shape)
    gathered = sparse.vstack(comm.allgather(rows), "csr")
    gathered.sum_duplicates()
    return gathered


def _gather_diagonal(matrix: PETSc.Mat) -> sparse.csr_matrix:
    """A matrix of one block for each flexible body and one for the rigid part."""
    return sparse.block_diag([_gather(block) for block in blocks_of(matrix)], "csr")


def _gather_constraints(
    system: MultibodySystem, state: State, sizes: list[int]
) -> sparse.csr_matrix:
    """Rows of the rigid part, then those of each coupling block: C u + B q = 0."""
    model = system.rigid_model
    G: Array = model.constraint_jacobian(state.q, state.joint_coordinates)
    rows: list[list[sparse.csr_matrix | None]] = [
        [*(sparse.csr_matrix((len(G), n)) for n in sizes[:-1]), sparse.csr_matrix(G)]
    ]
    for k, block in enumerate(system.coupling_blocks):
        row: list[sparse.csr_matrix | None] = [None] * len(sizes)
        row[k] = _gather(block.C)
        row[-1] = _gather(block.B)[:, : sizes[-1]]
        rows.append(row)
    return sparse.bmat(rows, "csr")
