"""The energy-momentum step that a kind of body has."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.time_stepping.body_step import BodyStep
from turbine_fenicsx.time_stepping.discrete_gradients import AlgorithmicStress
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.reduced_step import ReducedStep


class EnergyMomentumBody(BodyStep, Protocol):
    """A body in an energy-momentum step."""

    def start_step(self, u: PETSc.Vec, v: PETSc.Vec, times: StepTimes, gravity: Array) -> None:
        """Set the state at t_n, the step, and gravity [m/s^2]."""

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0."""


def make_step(
    model: BodyModel, stress: AlgorithmicStress | None, numerical_dissipation: float
) -> EnergyMomentumBody:
    """The step of a body. Collective; arguments as of `FlexibleStep`."""
    if isinstance(model, ReducedModel):
        if stress is not None:
            raise ModelError(
                f"stress is an algorithmic stress of your own, and {model.body.name!r} is reduced: "
                "it has the exact discrete gradient"
            )
        return ReducedStep(model, numerical_dissipation)
    return FlexibleStep(on_mesh(model, "energy-momentum steps"), stress, numerical_dissipation)
