"""View of a run for observers."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import Balance
from turbine_fenicsx.time_stepping.stepper import Stepper, StepReport


@dataclass(frozen=True)
class Snapshot:
    """Accepted step, or first state of a run, as observers get it. Equal on all ranks.

    Args:
        index: Number of accepted steps since t = 0.
        state: The state; valid until the observer returns.
        balance: Its energies and momenta.
        works: Work of each of `MultibodySystem.work_names` since t = 0 [J].
        dissipated: What each of `Stepper.dissipation_names` dissipated since t = 0 [J].
        energy_error: Total energy and dissipation minus initial energy and external work [J].
        constraint_error: Largest violation of a constraint [m, -].
        report: What the step took; None for the first state of a run, initial or resumed.
        wall_time: Seconds since the start of the run, earlier parts included.
        stepper: What made the step; lives as long as the simulation.
    """

    index: int
    state: State
    balance: Balance
    works: Array
    dissipated: Array
    energy_error: float
    constraint_error: float
    report: StepReport | None
    wall_time: float
    stepper: Stepper

    @property
    def external_work(self) -> float:
        """Work of all forces except gravity since t = 0 [J]."""
        return float(self.works.sum())
