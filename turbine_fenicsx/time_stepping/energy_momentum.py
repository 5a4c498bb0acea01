"""One energy-momentum step (BEM, BHEM) as nested blocks, eqs (21)-(24), (55)-(59).

Positions of the state at t_{n+1} fulfil all constraints, forces act in the middle of the step, and
all equations of motion are multiplied by dt^2/2; so are the multipliers.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Literal, Protocol

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.body_step_interface import BodyStep
from turbine_fenicsx.time_stepping.discrete_gradients import AlgorithmicStress
from turbine_fenicsx.time_stepping.first_guess import mean_turns
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.nested_step import NestedStep
from turbine_fenicsx.time_stepping.newton import NewtonStepper
from turbine_fenicsx.time_stepping.reduced_step import ReducedStep
from turbine_fenicsx.time_stepping.rigid_step import RigidData, RigidStep
from turbine_fenicsx.time_stepping.solver_options import SolverOptions


class EnergyMomentumBody(BodyStep, Protocol):
    """A body in an energy-momentum step."""

    def start_step(self, u: PETSc.Vec, v: PETSc.Vec, times: StepTimes, gravity: Array) -> None:
        """Set the state at t_n, the step, and gravity [m/s^2]."""

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0."""


@singledispatch
def make_step(
    model: BodyModel, stress: AlgorithmicStress | None, numerical_dissipation: float
) -> EnergyMomentumBody:
    """The step of a body. Collective; arguments as of `FlexibleStep`.

    ``make_step.register(MyModel, my_step)`` adds that of a new kind.

    Raises:
        TypeError: for a kind that has none.
    """
    raise TypeError(f"{describe(model)} has no energy-momentum step; make_step.register adds one")


make_step.register(FlexibleModel, FlexibleStep)


@make_step.register(ReducedModel)
def _make_reduced(
    model: ReducedModel, stress: AlgorithmicStress | None, numerical_dissipation: float
) -> ReducedStep:
    """The step of a reduced body, whose stress is its exact discrete gradient."""
    if stress is not None:
        raise ModelError(
            f"stress is an algorithmic stress of your own, and {model.body.name!r} is reduced: "
            "it has the exact discrete gradient"
        )
    return ReducedStep(model, numerical_dissipation)


class EnergyMomentumStep(NestedStep):
    """Nested residual and tangent of one energy-momentum step of a system.

    Args:
        system: The system.
        stress: Algorithmic stress of all flexible bodies; their exact discrete gradients if None.
        numerical_dissipation: chi >= 0 of the energy-decaying variant, see `FlexibleStep`; 0
            conserves energy.
        angle_form: Form of the augmented joint angles, "regular" or "paper".

    Raises:
        ModelError: for a dissipation out of range or an unknown form.
    """

    frames = (0.5, 1.0)

    def __init__(
        self,
        system: MultibodySystem,
        stress: AlgorithmicStress | None = None,
        numerical_dissipation: float = 0.0,
        angle_form: str = "regular",
    ) -> None:
        if not 0.0 <= numerical_dissipation < np.inf:
            raise ModelError(f"numerical_dissipation must be >= 0, got {numerical_dissipation:g}")
        if angle_form not in FORMS:
            raise ModelError(f"angle_form must be one of {sorted(FORMS)}, got {angle_form!r}")
        self._flexible = tuple(
            make_step(model, stress, numerical_dissipation) for model in system.flexible_models
        )
        self.rigid = RigidStep(system.rigid_model, FORMS[angle_form])
        super().__init__(system, self._flexible, self.rigid)
        self._weight = system.gravity_force(system.gravity)
        self._forces: tuple[Array, Array] = (np.zeros((0, 0)), np.zeros((0, 0)))

    def start_step(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step dt [s]."""
        system, times = self.system, StepTimes.from_start(state.time, dt)
        self._forces = system.evaluate_prescribed_forces(times.middle)
        load_q, load_T = (forces.sum(axis=0) for forces in self._forces)
        data = RigidData(
            q=state.q,
            T=state.joint_coordinates,
            dt_q_dot=dt * state.q_dot,
            impulse_q=times.half_dt2 * (self._weight + load_q),
            impulse_T=times.half_dt2 * load_T,
            prescribed=system.relation_values(times.end),
            paths=system.paths.values(times.end),
            times=times,
        )
        for f, u, v in zip(self._flexible, state.u, state.v, strict=True):
            f.start_step(u, v, times, system.gravity)
        self.set_start(state, dt, data)

    def guess(self, extrapolate: bool, r: Array | None = None) -> None:
        """Set X to the start of the iteration: x_n + dt P v_n, or x_n without extrapolation."""
        state, dt = self.start.state, self.start.dt
        factor, half_dt2 = dt if extrapolate else 0.0, self.rigid_data.times.half_dt2
        du, mu_c, r_part = self.split(self.x)
        if r is not None and not du:
            r_part.array[:] = r[: self.n_r]
            return
        P, one = mean_turns(state.q, state.q_dot, factor), np.eye(3)
        for i, c in enumerate(self.system.coupling_blocks):
            carrier = self.system.first_coordinate[c.carriers[0]] // 12 if c.carriers else None
            mean = one if carrier is None else P[carrier]
            velocities, forces = (x[i].array_r.reshape(-1, 3) for x in (state.v, state.coupling))
            du[i].array[:] = (velocities @ (factor * mean.T)).ravel()
            mu_c[i].array[:] = (forces @ (half_dt2 * (2.0 * mean - one).T)).ravel()
        if self.n_r and r is not None:
            r_part.array[:] = r
        elif self.n_r:
            dq = state.q_dot.reshape(-1, 4, 3) @ (factor * P.swapaxes(1, 2))
            multipliers = half_dt2 * state.multipliers
            r_part.array[:] = np.concatenate([dq.ravel(), factor * state.joint_rates, multipliers])

    def assemble_at_rest(self, body: int) -> None:
        """Assemble A_uu of a body at t_n for du = 0, where it is symmetric."""
        self._flexible[body].assemble_at_rest()

    def finish(self, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1}; works are exactly force times increment. Collective."""
        state, dt, model = self.start.state, self.start.dt, self.system.rigid_model
        du, mu_c, _ = self.split(self.x)
        r = self.rigid_unknowns()
        dq, dT, mu, nu, pi = model.split(r)
        out.time = state.time + dt
        out.q = state.q + dq
        out.q_dot = 2.0 / dt * dq - state.q_dot
        out.joint_coordinates = state.joint_coordinates + dT
        out.joint_rates = dT / dt
        out.multipliers = 2.0 / dt**2 * np.concatenate([mu, nu, pi])
        for i, increment in enumerate(du):
            out.u[i].waxpy(1.0, state.u[i], increment)
            state.v[i].copy(out.v[i])
            out.v[i].axpby(2.0 / dt, -1.0, increment)
            mu_c[i].copy(out.coupling[i])
            out.coupling[i].scale(2.0 / dt**2)
        load_q, load_T = self._forces
        return self.sum_works(
            load_q @ dq + load_T @ dT,
            self.rigid.motion_works(self.rigid_data, r),
            du,
            self.sum_drives(out.multipliers[self.driven], dq, dT),
        )


class EnergyMomentum(NewtonStepper):
    """The energy-momentum scheme of the paper.

    Constraints hold at the ends of the steps, momenta are conserved exactly, and so is energy
    except for what forces, dampers and numerical dissipation do, which is counted. Second order.

    Args:
        system: The system.
        stress: Algorithmic stress of all flexible bodies; their exact discrete gradients if None.
        numerical_dissipation: chi >= 0 of the energy-decaying variant, see `FlexibleStep`; 0
            conserves energy.
        angle_form: Form of the augmented joint angles, "regular" or "paper".
        options: Tolerances and linear solver.

    Attributes:
        energy_tolerance: Tolerance of the equations, which the balance of energy closes to; None
            with a custom stress, which need not conserve energy.

    Raises:
        ModelError: for a dissipation out of range or an unknown form.
    """

    forces_at = 0.5

    def __init__(
        self,
        system: MultibodySystem,
        stress: AlgorithmicStress | None = None,
        numerical_dissipation: float = 0.0,
        angle_form: Literal["regular", "paper"] = "regular",
        options: SolverOptions | None = None,
    ) -> None:
        step = EnergyMomentumStep(system, stress, numerical_dissipation, angle_form)
        super().__init__(step, options)
        self._rigid = step.rigid
        self.energy_tolerance = None if stress else self.options.tolerance

    def constraint_forces(self, q0: Array, T0: Array, state: State) -> tuple[Array, Array]:
        """Forces of constraints and joint coordinates in the step from (q0, T0) to a state."""
        return self._rigid.constraint_forces(
            q0, T0, state.q, state.joint_coordinates, state.multipliers
        )
