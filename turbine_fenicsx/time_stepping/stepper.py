"""Stepper interface: what makes one step after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True)
class StepReport:
    """Cost of one step.

    Args:
        newton_iterations: Newton iterations, failed attempts included.
        krylov_iterations: Krylov iterations in them; a direct solve counts as one.
        works: Work of each of `MultibodySystem.work_names` [J], zero for gravity.
        dissipated: What each of `Stepper.dissipation_names` dissipated [J].
        residual: Largest relative residual of any block at the end.
    """

    newton_iterations: int
    krylov_iterations: int
    works: tuple[float, ...]
    dissipated: tuple[float, ...]
    residual: float

    @property
    def work(self) -> float:
        """Work of all forces except gravity [J]."""
        return sum(self.works)


@runtime_checkable
class Stepper(Protocol):
    """An integrator of a system. All methods are collective.

    Attributes:
        system: The system.
        dissipation_names: Names of what dissipates, in the order of `StepReport.dissipated`.
        forces_at: Where in a step the multipliers and coupling forces of `State` act: 0.5 for the
            middle, 1 for the end.
        fallbacks: How often another attempt had to take over for one that failed.
    """

    system: MultibodySystem
    dissipation_names: tuple[str, ...]
    forces_at: float
    fallbacks: int

    @property
    def destroy(self) -> Callable[[], object]:
        """Frees all PETSc objects when called."""

    def advance(self, state: State, dt: float, out: State) -> StepReport:
        """One step from ``state`` to t + dt [s], into ``out``.

        Raises:
            StepFailure: if there is no solution; ``out`` is then unchanged.
        """

    def constraint_forces(self, q0: Array, T0: Array, state: State) -> tuple[Array, Array]:
        """Forces of constraints in the step from the configuration (q0, T0) to a state.

        Returns:
            As `RigidModel.constraint_forces`.
        """

    def save(self) -> RestartData:
        """Data that later steps depend on, apart from the state."""

    def restore(self, data: RestartData) -> None:
        """Restore the state of the stepper that saved this."""
