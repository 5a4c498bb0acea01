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

and second order. Neither energy nor momenta are conserved. In terms of the increment dy,

    v'_{n+1} = (dy - p)/s,    v_{n+1} = dy/r + w,

with s = (1 - alpha_f) beta h^2/(1 - alpha_m), r = beta h/gamma and what is known at t_n, p and w;
the equations of motion are multiplied by s, and so are the multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.element import StepTimes
from turbine_fenicsx.foundation.checks import check_number
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.materials.base import Viscous
from turbine_fenicsx.materials.kinematics import deformation_gradient, strain_rate
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.restart_data import RestartData
from turbine_fenicsx.system.rigid_model import RigidModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.force_round_off import ForceRoundOff, smallest_edges
from turbine_fenicsx.time_stepping.nested_step import NestedStep
from turbine_fenicsx.time_stepping.newton import NewtonStepper, SolverOptions

EARLY = 1e-12
"""Factor s [s^2] for which a step yields the accelerations of the first moment."""


class Coefficients(NamedTuple):
    """Numbers of the scheme for a spectral radius rho."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    @classmethod
    def of(cls, rho: float) -> Coefficients:
        """The second-order scheme with the least low-frequency dissipation."""
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 - alpha_m + alpha_f
        return cls(alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma)

    def scale(self, h: float) -> float:
        """The factor s of forces [s^2]."""
        return (1.0 - self.alpha_f) * self.beta * h * h / (1.0 - self.alpha_m)

    def known(self, v: Any, a: Any, acceleration: Any, h: float) -> tuple[Any, Any]:
        """p and w from velocities v, algorithmic and true accelerations at t_n."""
        lag = (self.alpha_m * a - self.alpha_f * acceleration) / (1.0 - self.alpha_f)
        p = h * v + h * h * (0.5 - self.beta) * a - self.scale(h) * lag
        ratio = self.gamma / self.beta
        return p, (1.0 - ratio) * v + h * (1.0 - 0.5 * ratio) * a

    def algorithmic(self, dy: Any, v: Any, a: Any, h: float) -> Any:
        """a_{n+1} for an increment dy."""
        return (dy - h * v - h * h * (0.5 - self.beta) * a) / (self.beta * h * h)


@dataclass
class Accelerations:
    """Accelerations at one time: algorithmic a and true ones v', of (q, T) and of each body."""

    time: float
    a: Array
    true: Array
    body_a: list[Array]
    body_true: list[Array]


@dataclass(frozen=True)
class EndData:
    """What a step of the rigid part is given: y = (q, T) at t_n, p, w, s, r and loads at t_{n+1}."""

    y: Array
    n_q: int
    p: Array
    w: Array
    s: float
    r: float
    loads: Array
    prescribed: Array
    times: StepTimes


class RigidEnd:
    """Equations of motion and constraints of the rigid part at the end of a step."""

    def __init__(self, model: RigidModel) -> None:
        self.model = model

    def residual(self, data: EndData, r: Array) -> tuple[Array, Array]:
        """R_r and the sum of the absolute values of its terms."""
        m, (dq, multipliers, q1, T1) = self.model, self._unknowns(data, r)
        D, (_, values) = m.constraint_jacobian(q1, T1), m.at(q1)
        n = data.y.size
        inertia = np.zeros(n)
        inertia[: m.n_q] = m.masses * (dq - data.p[: m.n_q])
        R = np.concatenate(
            [
                # equations of motion at t_{n+1}
                inertia + multipliers @ D - data.s * data.loads,
                # constraints at t_{n+1}
                m.constraint_values(q1, T1)[: m.n_constraints + m.n_angles],
                m.S @ T1 - data.prescribed,
            ]
        )
        scale = np.concatenate(
            [
                np.abs(inertia) + np.abs(multipliers) @ np.abs(D) + np.abs(data.s * data.loads),
                np.abs(m.functions.constant[m.g]) + np.abs(m.at(q1)[0][m.g]) @ np.abs(q1),
                np.abs(values[m.c]) + np.abs(values[m.s]) + np.abs(T1),
                np.maximum(1.0 + np.abs(data.prescribed), np.abs(m.S) @ np.abs(T1)),
            ]
        )
        scale[: m.n_q] += m.masses * (np.abs(dq) + np.abs(data.p[: m.n_q]))
        forces, sizes, _ = m.element_forces(*self._around(data, r), data.times)
        if forces.size:
            R[:n] -= data.s * forces
            scale[:n] += data.s * sizes
        return R, scale

    def tangent(self, data: EndData, r: Array) -> Array:
        """Derivative of R_r with respect to r."""
        m, (_, multipliers, q1, T1) = self.model, self._unknowns(data, r)
        n, K = data.y.size, np.zeros((self.model.size,) * 2)
        K[:n, :n] = m.constraint_stiffness(q1, T1, multipliers)
        K[: m.n_q, : m.n_q] += m.mass_matrix
        K[n:, :n] = m.constraint_jacobian(q1, T1)
        K[:n, n:] = K[n:, :n].T
        ends, times, half = self._around(data, r), data.times, 0.5 * data.times.dt / data.r
        _, _, slope_1 = m.element_forces(*ends, times)
        if slope_1 is not None:
            # a step backwards has the same forces: the derivative with respect to its start
            back = StepTimes(-times.dt, times.middle, times.middle)
            _, _, slope_0 = m.element_forces(*ends[::-1], back)
            assert slope_0 is not None
            K[:n, :n] -= data.s * ((1.0 - half) * slope_0 + (1.0 + half) * slope_1)
        return K

    def acceptable(self, data: EndData, r: Array) -> bool:
        """Whether angles lie on the right branch and redundant constraints hold."""
        _, _, q1, T1 = self._unknowns(data, r)
        return self.model.acceptable(q1, T1, self.model.split(r).dT)

    def _unknowns(self, data: EndData, r: Array) -> tuple[Array, Array, Array, Array]:
        """dq, the multipliers, and q and T at the end of the step."""
        n, dy = data.y.size, r[: data.y.size]
        y1 = data.y + dy
        return dy[: data.n_q], r[n:], y1[: data.n_q], y1[data.n_q :]

    def _around(self, data: EndData, r: Array) -> tuple[Array, Array]:
        """Two configurations h apart with y_{n+1} between them, moving as the end does.

        The force elements' mean over the step between them is their force at the end, but for
        O(h^2).
        """
        dy = r[: data.y.size]
        way = 0.5 * data.times.dt * (dy / data.r + data.w)
        return data.y + dy - way, data.y + dy + way


class FlexibleEnd:
    """Equations of motion of a flexible body at the end of a step.

    Attributes:
        tangent: Matrix of the tangent.
        round_off: This rank's sum of the squares of the round-off of the residual.
        dissipations: What dissipates in this body, names.
    """

    def __init__(self, model: FlexibleModel) -> None:
        self.model = model
        mesh, V = model.body.mesh, model.space
        self._u_n, self._du, self._p, self._w = (fem.Function(V) for _ in range(4))
        self._s, self._rate, self._dt = (fem.Constant(mesh, 1.0) for _ in range(3))
        self._gravity = fem.Constant(mesh, np.zeros(3))
        test, delta = ufl.TestFunction(V), ufl.TrialFunction(V)
        u, v = self._u_n + self._du, self._rate * self._du + self._w
        inertia = self._du - self._p - self._s * self._gravity
        R = model.density * ufl.dot(inertia, test) * model.dx_mass
        R += self._s * model.forces(u, v, test)
        self._residual = _compat.compile_form(R)
        self._tangent = _compat.compile_form(ufl.derivative(R, self._du, delta))
        # works and losses by the midpoint rule
        u_mid, v_mid = self._u_n + 0.5 * self._du, self._du / self._dt
        works = model.surface.integrals(u_mid, v_mid, self._du)
        self._works = [_compat.compile_form(work) for work in works]
        self._losses = []
        if isinstance(model.body.material, Viscous):
            F = deformation_gradient(u_mid)
            dE = strain_rate(F, ufl.grad(self._du))
            S = model.body.material.viscous_stress(dE / self._dt, model.parameter)
            self._losses.append(_compat.compile_form(ufl.inner(S, dE) * model.dx_stress))
        self.dissipations = ("viscosity",) * len(self._losses)
        self.tangent = _compat.create_matrix(self._tangent)
        self._round_off = self._estimate_round_off()
        self._masses = np.repeat(np.abs(model.nodal_mass), 3)
        self._fixed_terms, self.round_off = np.zeros_like(self._masses), 0.0

    def begin(self, u: PETSc.Vec, p: Array, w: Array, s: float, r: float, time: float) -> None:
        """Set u_n, p, w, s, r and the end of the step [s]."""
        model = self.model
        model.copy_to(self._u_n, u)
        for function, values in ((self._p, p), (self._w, w)):
            function.x.array[: values.size] = values
            function.x.scatter_forward()
        self._s.value, self._rate.value = s, 1.0 / r
        model.set_loads(time)
        self.round_off = s * s * self._round_off.square(p, r)
        self._fixed_terms = self._masses * (np.abs(p) + s * np.linalg.norm(self._gravity.value))

    def set_gravity(self, gravity: Array) -> None:
        """Set the acceleration of gravity [m/s^2]."""
        self._gravity.value[:] = gravity

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble R_u for the increment du into R."""
        self.model.copy_to(self._du, du)
        self.model.assemble(self._residual, R)
        for dofs, force in self.model.nodal_forces:
            R.array[dofs] -= float(self._s.value) * force[: dofs.stop - dofs.start]

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of R_u into `tangent`."""
        self.model.copy_to(self._du, du)
        _compat.assemble_matrix(self.tangent, self._tangent)

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0."""
        self._du.x.array[:] = 0.0
        _compat.assemble_matrix(self.tangent, self._tangent)

    def term_scale(self, du: PETSc.Vec) -> float:
        """This rank's sum of the squares of the inertia and gravity terms of R_u."""
        terms = self._masses * np.abs(du.array_r) + self._fixed_terms
        return float(np.dot(terms, terms))

    def works(self, du: PETSc.Vec, times: StepTimes) -> tuple[Array, Array]:
        """This rank's part of the work of each load, and of each loss [J], in the increment du."""
        self._dt.value = times.dt
        self.model.copy_to(self._du, du)
        self.model.set_loads(times.middle)
        works = [float(fem.assemble_scalar(work)) for work in self._works]
        for dofs, force in self.model.nodal_forces:
            works.append(float(np.sum(force[: dofs.stop - dofs.start] * du.array_r[dofs])))
        losses = [float(fem.assemble_scalar(loss)) for loss in self._losses]
        return np.array(works), np.array(losses)

    def _estimate_round_off(self) -> ForceRoundOff:
        """The round-off of the forces, from tangents at rest for s = 1."""
        diagonals = []
        for rate in (0.0, 1.0):
            self._rate.value = rate
            _compat.assemble_matrix(self.tangent, self._tangent)
            vector = self.tangent.getDiagonal()
            diagonals.append(np.array(vector.array_r).reshape(-1, 3))
            vector.destroy()
        model = self.model
        edges = smallest_edges(model.space, model.local_positions)[: model.n_owned]
        return ForceRoundOff(edges, diagonals[0], diagonals[1] - diagonals[0])


class GeneralisedAlphaStep(NestedStep):
    """Nested residual and tangent of one step; keeps the accelerations of its two ends.

    Args:
        system: The system.
        spectral_radius: rho.
    """

    frames = (1.0, 1.0)

    def __init__(self, system: MultibodySystem, spectral_radius: float) -> None:
        self.coefficients = Coefficients.of(spectral_radius)
        self._flexible = tuple(FlexibleEnd(model) for model in system.flexible_models)
        for body in self._flexible:
            body.set_gravity(system.gravity)
        super().__init__(system, self._flexible, RigidEnd(system.rigid_model))
        self.dissipation_names = (
            *(e.name for e in system.elements if e.kind == "dissipative"),
            *(f"{name} of {f.model.body.name}" for f in self._flexible for name in f.dissipations),
        )
        kinds = np.array([e.kind for e in system.elements], dtype=object)
        self._external, self._dissipative = kinds == "external", kinds == "dissipative"
        self._driven = np.array([r.motion is not None for r in system.relations], dtype=bool)
        self._weight = system.gravity_force(system.gravity)
        self._times = StepTimes.from_start(0.0, 1.0)
        self.at_start: Accelerations | None = None
        self.at_end: Accelerations | None = None

    def begin(self, state: State, dt: float) -> None:
        """Set the state at t_n and the step dt [s]; the accelerations there are known or found."""
        for known in (self.at_end, self.at_start):
            if known is not None and abs(known.time - state.time) <= 1e-9 * dt:
                self.at_start = known
                break
        else:
            self.at_start = self._first_accelerations(state, dt)
        c, now = self.coefficients, self.at_start
        rigid = c.known(self._rates(state), now.a, now.true, dt)
        bodies = [
            c.known(v.array_r, a, true, dt)
            for v, a, true in zip(state.v, now.body_a, now.body_true, strict=True)
        ]
        times = StepTimes(dt, state.time + dt, state.time + dt)
        self._begin(state, dt, times, rigid, bodies, c.scale(dt), c.beta * dt / c.gamma)

    def _begin(
        self,
        state: State,
        dt: float,
        times: StepTimes,
        rigid: tuple[Array, Array],
        bodies: list[tuple[Array, Array]],
        s: float,
        r: float,
    ) -> None:
        """Set what all parts are given."""
        system = self.system
        load_q, load_T = (forces.sum(axis=0) for forces in system.forces_by_load(times.end))
        loads = np.concatenate([load_q + self._weight, load_T])
        y, prescribed = np.concatenate([state.q, state.angles]), system.relation_values(times.end)
        data = EndData(y, state.q.size, *rigid, s, r, loads, prescribed, times)
        for f, u, (p, w) in zip(self._flexible, state.u, bodies, strict=True):
            f.begin(u, p, w, s, r, times.end)
        self.begin_at(state, dt, data)

    def guess(self, extrapolate: bool, r: Array | None = None) -> None:
        """Set X to x_n + dt v_n + dt^2/2 a_n, or to x_n without extrapolation."""
        state, dt, now, data = self.start.state, self.start.dt, self.at_start, self.rigid_data
        assert now is not None
        factor = 1.0 if extrapolate else 0.0
        du, mu_c, r_part = self.split(self.x)
        for increment, v, a in zip(du, state.v, now.body_a, strict=True):
            increment.array[:] = factor * (dt * v.array_r + 0.5 * dt * dt * a)
        for mu, force in zip(mu_c, state.coupling, strict=True):
            force.copy(mu)
            mu.scale(data.s)
        if self.n_r and r is not None:
            r_part.array[:] = r
        elif self.n_r:
            dy = factor * (dt * self._rates(state) + 0.5 * dt * dt * now.a)
            r_part.array[:] = np.concatenate([dy, data.s * state.multipliers])

    def assemble_at_rest(self, body: int) -> None:
        """Assemble A_uu of a body at t_n for du = 0."""
        self._flexible[body].assemble_at_rest()

    def finish(self, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1}; works are those of the midpoint rule. Collective."""
        state, dt, data, c = self.start.state, self.start.dt, self.rigid_data, self.coefficients
        now = self.at_start
        assert now is not None
        du, mu_c, _ = self.split(self.x)
        r = self.rigid_unknowns()
        n = data.y.size
        dy, dq, dT = r[:n], r[: data.n_q], r[data.n_q : n]
        rates = dy / data.r + data.w
        end = Accelerations(
            state.time + dt,
            c.algorithmic(dy, self._rates(state), now.a, dt),
            (dy - data.p) / data.s,
            [],
            [],
        )
        out.time, out.q, out.angles = end.time, state.q + dq, state.angles + dT
        out.q_dot, out.angle_rates = rates[: data.n_q], rates[data.n_q :]
        out.multipliers = r[n:] / data.s
        for k, increment in enumerate(du):
            v, a, true = state.v[k].array_r, now.body_a[k], now.body_true[k]
            p, w = c.known(v, a, true, dt)
            end.body_a.append(c.algorithmic(increment.array_r, v, a, dt))
            end.body_true.append((increment.array_r - p) / data.s)
            out.v[k].array[:] = increment.array_r / data.r + w
            out.u[k].waxpy(1.0, state.u[k], increment)
            mu_c[k].copy(out.coupling[k])
            out.coupling[k].scale(1.0 / data.s)
        self.at_end = end
        return self._works(state, out, du)
