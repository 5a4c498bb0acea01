"""View of a run for observers."""

from __future__ import annotations

import weakref
from dataclasses import dataclass

from turbine_fenicsx.foundation.errors import ModelError
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
        maker: Reference to what made the step, which lives as long as the simulation.
        initial_potential: Potential energy at t = 0, from which it counts [J].
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
    maker: weakref.ReferenceType[Stepper]
    initial_potential: float = 0.0

    def __repr__(self) -> str:
        """Its time, energies and errors."""
        b, report = self.balance, self.report
        steps = "" if report is None else f", {report.newton_iterations} iterations"
        return (
            f"Snapshot of step {self.index} at t = {self.state.time:.6g} s{steps}\n"
            f"  energy {b.total:.6g} J: kinetic {b.kinetic:.6g}, strain {b.strain:.6g}, "
            f"potential {b.potential:.6g}, springs {b.spring:.6g}\n"
            f"  external work {self.external_work:.6g} J, dissipated "
            f"{self.dissipated.sum():.6g} J, energy error {self.energy_error:.2g} J\n"
            f"  constraint error {self.constraint_error:.2g}, wall time {self.wall_time:.3g} s"
        )

    @property
    def stepper(self) -> Stepper:
        """The stepper that made the step; a ModelError once its simulation is gone."""
        stepper = self.maker()
        if stepper is None:
            raise ModelError(
                "the stepper of this snapshot is gone with its simulation: keep the Simulation, or "
                "give it a stepper of yours"
            )
        return stepper

    @property
    def stored_energy(self) -> float:
        """The largest of its kinetic, strain and spring energy and the change of the potential [J].

        Errors of the balance count to the largest of a run. The potential itself depends on where
        the origin is.
        """
        b = self.balance
        parts = b.kinetic, b.strain, b.spring, b.potential - self.initial_potential
        return max(map(abs, parts))

    @property
    def external_work(self) -> float:
        """Work of all forces except gravity since t = 0 [J]."""
        return float(self.works.sum())
