"""The nested blocks of a step in time, as linear solvers see them."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from petsc4py import PETSc

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.nested_blocks import NestedBlocks
from turbine_fenicsx.system.state import State


@dataclass(frozen=True)
class StepStart:
    """Where a step starts.

    Args:
        dt: Length of the step [s].
    """

    state: State
    dt: float


class StepBlocks(NestedBlocks):
    """The blocks of a step: where they are evaluated, and in which frames.

    Attributes:
        start: Where the step starts, set by `start_step`.
        frames: The parts of the step after which the material has turned into the frames of the
            forces and of the unknowns.
    """

    x: PETSc.Vec
    start: StepStart
    frames: tuple[float, float]

    @abstractmethod
    def start_step(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step dt [s]."""

    @abstractmethod
    def assemble_at_rest(self, body: int) -> None:
        """Assemble A_uu of a body at t_n, where nothing moves and it is symmetric."""

    @abstractmethod
    def update_body_tangent(self, body: int, x: PETSc.Vec) -> None:
        """Assemble only A_uu of a body at X."""

    @abstractmethod
    def update_rigid_tangent(self, x: PETSc.Vec) -> None:
        """Assemble only the rigid block K_r of the tangent at X."""

    @abstractmethod
    def mass_weights(self) -> Array:
        """Masses that belong to this rank's entries of X, zero for multipliers and angles."""
