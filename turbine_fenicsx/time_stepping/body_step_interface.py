"""The interface of a flexible body in a step."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array


class BodyWorks(Protocol):
    """Works of forces on a flexible body in a step, and what dissipates in it."""

    @property
    def losses(self) -> tuple[str, ...]: ...  # noqa: D102

    def works(self, du: PETSc.Vec) -> tuple[Array, Array]:
        """This rank's part of the work of each force, and of each of the losses [J]."""


class BodyStep(Protocol):
    """A flexible body in a step. Methods are collective.

    Attributes:
        tangent: Matrix that `assemble_tangent` fills.
        midpoint: Works of forces, and what dissipates.
    """

    tangent: PETSc.Mat

    @property
    def round_off(self) -> float:
        """This rank's sum of the squares of the round-off of the residual [(kg m)^2]."""

    @property
    def midpoint(self) -> BodyWorks: ...  # noqa: D102

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble R_u for the increment du into R."""

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of R_u into `tangent`."""

    @property
    def keeps_tangent(self) -> bool:
        """Whether `turn_tangent` can take the last tangent to where the body is."""

    def turn_tangent(self, du: PETSc.Vec) -> tuple[Array | None, Array]:
        """Rotations of the last tangent if new, and what is added to R_u; see `KeptTangent`."""

    def forget_tangent(self) -> None:
        """An iteration failed, perhaps as the tangent is old."""

    def term_scale(self, du: PETSc.Vec) -> float:
        """This rank's sum of the squares of the largest terms of R_u."""

    def start_iteration(self) -> None:
        """An iteration begins, perhaps not the first of the step."""

    def save(self) -> RestartData:
        """Data that later steps depend on, apart from the state."""

    def restore(self, data: RestartData) -> None:
        """Restore what was saved."""


class MemorylessStep:
    """Base of body steps that depend on nothing but the state and the unknowns.

    Attributes:
        keeps_tangent: Each tangent is new.
    """

    keeps_tangent = False

    def turn_tangent(self, du: PETSc.Vec) -> tuple[Array | None, Array]:
        """No tangent is kept."""
        raise NotImplementedError

    def forget_tangent(self) -> None:
        """There is nothing to forget."""

    def start_iteration(self) -> None:
        """There is nothing to forget."""

    def save(self) -> RestartData:
        """Empty data."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """There is nothing to restore."""
