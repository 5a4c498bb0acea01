"""The bordered equations of a step, as linear solvers see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from petsc4py import PETSc

from turbine_fenicsx.foundation.dense import ScaledFactor
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True)
class StepStart:
    """Where a step starts.

    Args:
        state: State at t_n.
        dt: Length of the step [s].
    """

    state: State
    dt: float


class Blocks(Protocol):
    """Nested matrix of A_uu, C and B of each flexible body, and K_r of the rigid part.

    Attributes:
        system: The system.
        tangents: A_uu of each flexible body.
        rigid_tangent: K_r on rank 0, shape (n_r, n_r); empty on the others.
    """

    system: MultibodySystem
    tangents: tuple[PETSc.Mat, ...]
    rigid_tangent: Array

    @property
    def tangent_matrix(self) -> PETSc.Mat:
        """The nested matrix."""

    def new_nested_vector(self) -> PETSc.Vec:
        """New nested vector with the layout of the unknowns, zero."""

    def split(self, x: PETSc.Vec) -> tuple[list[PETSc.Vec], list[PETSc.Vec], PETSc.Vec]:
        """Parts (du of each body, mu_c of each body, r) of a nested vector."""

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble all blocks at the unknowns X."""

    def solve_rigid(self, reduced: ScaledFactor, r: PETSc.Vec) -> Array:
        """Solve the reduced equations on rank 0, overwriting r, and hand r to all ranks."""


class StepBlocks(Blocks, Protocol):
    """The blocks of a step in time: where they are evaluated, and in which frames.

    Attributes:
        x: Nested vector of the unknowns.
        start: Where the step starts, set by `begin`.
        frames: The parts of the step after which the material has turned into the frames of the
            forces and of the unknowns.
    """

    x: PETSc.Vec
    start: StepStart
    frames: tuple[float, float]

    def begin(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step [s]."""

    def assemble_at_rest(self, body: int) -> None:
        """Assemble A_uu of a body at t_n, where nothing moves and it is symmetric."""

    def update_rigid_tangent(self, x: PETSc.Vec) -> None:
        """Assemble only the rigid block K_r of the tangent at X."""

    def mass_weights(self) -> Array:
        """Masses that belong to this rank's entries of X, zero for multipliers and angles."""
