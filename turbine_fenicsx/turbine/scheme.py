"""The integrator of a case."""

from __future__ import annotations

from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.newton import SolverOptions
from turbine_fenicsx.turbine.case.case import Case


def make_stepper(case: Case, system: MultibodySystem) -> EnergyMomentum:
    """What integrates the turbine of a case. Collective."""
    solver, turbine = case.solver, case.turbine
    return EnergyMomentum(
        system,
        numerical_dissipation=turbine.numerical_dissipation,
        angle_form=turbine.angle_form,
        options=SolverOptions(
            linear_solver=solver.preconditioner,
            tolerance=solver.tolerance,
            max_iterations=solver.max_iterations,
        ),
    )
