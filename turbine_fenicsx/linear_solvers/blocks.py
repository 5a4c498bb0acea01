"""The bordered equations of a step, as linear solvers see them."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

from turbine_fenicsx.foundation.dense import ScaledFactor
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class StepBlocks(Protocol):
    """Nested tangent of one step: A_uu, C and B of each flexible body, K_r of the rigid part."""

    @property
    def system(self) -> MultibodySystem:
        """The system."""

    @property
    def state(self) -> State:
        """State at t_n."""

    @property
    def dt(self) -> float:
        """Step [s]."""

    @property
    def x(self) -> PETSc.Vec:
        """Nested vector of the unknowns."""

    @property
    def tangent_matrix(self) -> PETSc.Mat:
        """Nested matrix of the tangent."""

    @property
    def rigid_tangent(self) -> Array:
        """K_r on rank 0, shape (n_r, n_r); empty on the others."""

    def begin(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step [s]."""

    def split(self, x: PETSc.Vec) -> tuple[list[PETSc.Vec], list[PETSc.Vec], PETSc.Vec]:
        """Parts (du of each body, mu_c of each body, r) of a nested vector."""

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble the tangent at X."""

    def update_rigid_tangent(self, x: PETSc.Vec) -> None:
        """Assemble only the rigid block K_r of the tangent at X."""

    def solve_rigid(self, reduced: ScaledFactor, r: PETSc.Vec) -> Array:
        """Solve the reduced equations on rank 0, overwriting r, and hand r to all ranks."""

    def mass_weights(self) -> Array:
        """Masses that belong to this rank's entries of X, zero for multipliers and angles."""
