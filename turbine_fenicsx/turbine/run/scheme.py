"""The integrator of a case."""

from __future__ import annotations

from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha
from turbine_fenicsx.time_stepping.newton import SolverOptions
from turbine_fenicsx.time_stepping.stepper import Stepper
from turbine_fenicsx.turbine.case.case import Case


def make_stepper(case: Case, system: MultibodySystem) -> Stepper:
    """Integrator of the turbine of a case. Collective."""
    options = SolverOptions(
        linear_solver=case.solver.linear_solver,
        tolerance=case.solver.tolerance,
        max_iterations=case.solver.max_iterations,
    )
    if case.time.scheme == "generalised_alpha":
        return GeneralisedAlpha(system, case.time.spectral_radius, options)
    return EnergyMomentum(
        system,
        numerical_dissipation=case.turbine.numerical_dissipation,
        angle_form=case.turbine.angle_form,
        options=options,
    )
