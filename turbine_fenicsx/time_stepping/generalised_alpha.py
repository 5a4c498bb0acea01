"""The generalised-alpha method for constrained systems of index 3 (Arnold and Bruels 2007).

With the step h, positions y, velocities v and algorithmic accelerations a follow Newmark's rule,

    y_{n+1} = y_n + h v_n + h^2 [(1/2 - beta) a_n + beta a_{n+1}],
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}],

where a lags behind the accelerations v' of the equations of motion at the ends of the steps,

    (1 - alpha_m) a_{n+1} + alpha_m a_n = (1 - alpha_f) v'_{n+1} + alpha_f v'_n,
    M v'_{n+1} + D(y_{n+1})^T lambda_{n+1} = F(y_{n+1}, v_{n+1}, t_{n+1}),    Phi(y_{n+1}) = 0.

The spectral radius rho at infinite frequency gives all four numbers,

    alpha_m = (2 rho - 1)/(rho + 1),    alpha_f = rho/(rho + 1),
    gamma = 1/2 - alpha_m + alpha_f,    beta = (gamma + 1/2)^2/4,

and second order. Neither energy nor momenta are conserved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.argument_checks import check_number
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.end_step import EndScheme, EndStep
from turbine_fenicsx.time_stepping.newton import NewtonStepper
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

EARLY = 1e-12
"""Factor s [s^2] of forces for which a step yields the accelerations of its first moment."""


class Coefficients(NamedTuple):
    """Numbers of the scheme."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    @classmethod
    def of(cls, rho: float) -> Coefficients:
        """Those for a spectral radius rho at infinite frequency."""
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 - alpha_m + alpha_f
        return cls(alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma)


@dataclass(frozen=True)
class Accelerations:
    """Accelerations at one time, laid out like `EndScheme.p`.

    Args:
        time: The time [s].
        true: v'; without meaning for joint coordinates, which have no mass.
    """

    time: float
    algorithmic: Array
    true: Array
    drives: Array


class GeneralisedAlphaStep(EndStep):
    """Nested residual and tangent of one step; keeps the accelerations at its two ends.

    Attributes:
        ends: The accelerations at the ends of the step, as far as they are known.
    """

    def __init__(self, system: MultibodySystem, spectral_radius: float) -> None:
        super().__init__(system)
        self.coefficients = Coefficients.of(spectral_radius)
        self.ends: list[Accelerations] = []

    def start_step(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step dt [s]; the accelerations there are known or found."""
        same = (x for x in reversed(self.ends) if abs(x.time - state.time) <= 1e-6 * dt)
        now = next(same, None) or self._find_accelerations(state, dt)
        self.ends, c, v = [now], self.coefficients, self.velocities(state)
        # v'_{n+1} in terms of dy: Newmark's formulas in the balance of accelerations
        s = (1.0 - c.alpha_f) * c.beta * dt * dt / (1.0 - c.alpha_m)
        lag = (c.alpha_m * now.algorithmic - c.alpha_f * now.true) / (1.0 - c.alpha_f)
        ratio = c.gamma / c.beta
        scheme = EndScheme(
            s=s,
            r=dt / ratio,
            p=dt * v + dt * dt * (0.5 - c.beta) * now.algorithmic - s * lag,
            w=(1.0 - ratio) * v + dt * (1.0 - 0.5 * ratio) * now.algorithmic,
        )
        self._scheme = scheme
        self.start_scheme(state, dt, state.time + dt, scheme)

    def guess(self, extrapolate: bool, r: Array | None = None) -> None:
        """Set X to x_n + dt v_n + dt^2/2 a_n, or to x_n without extrapolation."""
        state, dt = self.start.state, self.start.dt
        dy = dt * self.velocities(state) + 0.5 * dt * dt * self.ends[0].algorithmic
        self.set_increments(dy if extrapolate else np.zeros_like(dy), state)
        if self.n_r and r is not None:
            self.split(self.x)[2].array[:] = r

    def finish(self, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1}; works are those of the midpoint rule. Collective."""
        state, dt, c, now = self.start.state, self.start.dt, self.coefficients, self.ends[0]
        dy, v = self.increments(self.x), self.velocities(state)
        # accelerations at t_{n+1} from Newmark's formula for dy
        known = dt * v + dt * dt * (0.5 - c.beta) * now.algorithmic
        a = (dy - known) / (c.beta * dt * dt)
        true = (dy - self._scheme.p) / self._scheme.s
        done = self.write_state(dy / self._scheme.r + self._scheme.w, now.drives, out)
        self.ends = [now, Accelerations(state.time + dt, a, true, out.multipliers[self.driven])]
        return done

    def _find_accelerations(self, state: State, dt: float) -> Accelerations:
        """Accelerations of the motion from a state, M v' + D^T lambda = F and D v' = -D' v + p''.

        They are the increments over s of a step that is too short for anything to move.
        """
        v = self.velocities(state)
        self.start_scheme(state, dt, state.time, EndScheme(EARLY, np.inf, np.zeros(v.size), v))
        model, system = self.system.rigid_model, self.system
        driven = [
            (p(state.time + 2.0 * dt) - 2.0 * p(state.time + dt) + p(state.time)) / dt**2
            for p in (system.paths.values, system.relation_values)
        ]
        x, zero, R = self.new_nested_vector(), self.new_nested_vector(), self.residual_vector
        self.residual(zero, R)
        _, R_c, R_r = self.split(R)
        for part in R_c:
            part.set(0.0)
        if self.n_r:
            y, y_dot = self.rigid_data.y, self.split_flat(v)[-1]
            R_r.array[y.size :] = EARLY * self._curvature(y, y_dot)
            R_r.array[y.size :] -= EARLY * np.concatenate(driven)
        solver = Elimination(self, "initial_")
        solver.update(zero)
        solver.solve(R, x)
        solver.destroy()
        a = -self.increments(x) / EARLY
        r = -self.on_all_ranks(self.split(x)[2]) / EARLY
        drives = r[model.n_q + model.n_T :][self.driven]
        x.destroy()
        zero.destroy()
        return Accelerations(state.time, a, a, drives)

    def _curvature(self, y: Array, v: Array) -> Array:
        """D' v, the acceleration of the constraints along a motion without acceleration.

        By central differences, which are exact for quadratic constraints.
        """
        model = self.system.rigid_model
        n, e = model.n_q, 1e-4 / max(float(np.max(np.abs(v), initial=0.0)), 1.0)
        ends = [model.constraint_jacobian((y + d)[:n], (y + d)[n:]) for d in (e * v, -e * v)]
        return (ends[0] - ends[1]) @ v / (2.0 * e)


class GeneralisedAlpha(NewtonStepper):
    """The generalised-alpha method: damps high frequencies, conserves neither energy nor momenta.

    Args:
        system: The system.
        spectral_radius: rho in [0, 1): what a step leaves of a mode of infinite frequency.
        options: Tolerances and linear solver.

    Raises:
        ModelError: for a spectral radius out of range.
    """

    forces_at = 1.0

    def __init__(
        self,
        system: MultibodySystem,
        spectral_radius: float = 0.9,
        options: SolverOptions | None = None,
    ) -> None:
        rho = check_number("spectral_radius", spectral_radius)
        if not 0.0 <= rho < 1.0:
            raise ModelError(f"spectral_radius must be at least 0 and below 1, got {rho:g}")
        self._equations = GeneralisedAlphaStep(system, rho)
        super().__init__(self._equations, options)

    def constraint_forces(self, q0: Array, T0: Array, state: State) -> tuple[Array, Array]:
        """Forces of constraints and joint coordinates at the end of the step to a state."""
        return self.system.rigid_model.constraint_forces(
            state.q, state.joint_coordinates, state.multipliers
        )

    def save(self) -> RestartData:
        """Data that later steps depend on, apart from the state: the accelerations, too."""
        data = super().save()
        for end in self._equations.ends[-1:]:
            saved = RestartData({"time": end.time}, {"drives": end.drives})
            for name, values in (("algorithmic", end.algorithmic), ("true", end.true)):
                *bodies, saved.arrays[name] = self._equations.split_flat(values)
                saved.nodal[name] = tuple(x.reshape(-1, 3) for x in bodies)
            data.add("accelerations", saved)
        return data

    def restore(self, data: RestartData) -> None:
        """Restore the state of the stepper that saved this."""
        super().restore(data)
        saved = data.part("accelerations")
        self._equations.ends = []
        if saved:
            algorithmic, true = (
                np.concatenate(
                    [*(x.ravel() for x in saved.nodal.get(name, ())), saved.arrays[name]]
                )
                for name in ("algorithmic", "true")
            )
            time, drives = saved.numbers["time"], saved.arrays["drives"]
            now = Accelerations(time, algorithmic, true, drives)
            self._equations.ends = [now]
