"""Equations of motion at the end of a step, for schemes of the Newmark family.

In any scheme, with the increment dy of all positions from t_n on

    v'_{n+1} = (dy - p)/s,    v_{n+1} = dy/r + w,

where the numbers s [s^2] and r [s] and what is known at t_n, p and w, distinguish the schemes.
Multiplied by s, and so are the multipliers, the step is

    M (dy - p) + s D(y_{n+1})^T lambda_{n+1} = s F(y_{n+1}, v_{n+1}, t_{n+1}),    Phi(y_{n+1}) = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.linear_form import LinearForm
from turbine_fenicsx.system.make_model import on_mesh
from turbine_fenicsx.system.rigid_model import RigidModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.body_step_interface import MemorylessStep
from turbine_fenicsx.time_stepping.force_round_off import ForceRoundOff, smallest_edges
from turbine_fenicsx.time_stepping.midpoint_works import MidpointWorks
from turbine_fenicsx.time_stepping.nested_step import NestedStep


@dataclass(frozen=True)
class EndScheme:
    """Coefficients that distinguish schemes.

    Args:
        s: Factor of the forces [s^2].
        r: Increment over change of velocity [s].
        p: Increment without acceleration at t_{n+1}; of this rank's nodes of each flexible body one
            after another, then of (q, T).
        w: Velocity at t_{n+1} without increment, laid out like p.
    """

    s: float
    r: float
    p: Array
    w: Array


@dataclass(frozen=True)
class EndData:
    """Input of a step of the rigid part.

    Args:
        y: (q, T) at t_n, shape (n_y,).
        n_q: Number of coordinates q.
        applied: All prescribed forces at t_{n+1}, shape (n_y,).
        paths: Right-hand sides of the constraints at t_{n+1}.
    """

    y: Array
    n_q: int
    p: Array
    w: Array
    s: float
    r: float
    applied: Array
    prescribed: Array
    paths: Array
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
                inertia + multipliers @ D - data.s * data.applied,
                # constraints at t_{n+1}
                m.constraint_values(q1, T1)[: m.n_constraints + m.n_T] - data.paths,
                m.S @ T1 - data.prescribed,
            ]
        )
        scale = np.concatenate(
            [
                np.abs(inertia) + np.abs(multipliers) @ np.abs(D) + np.abs(data.s * data.applied),
                np.abs(m.functions.constant[m.g]) + np.abs(m.at(q1)[0][m.g]) @ np.abs(q1),
                np.abs(values[m.c]) + np.abs(values[m.s]) + np.abs(T1),
                np.maximum(1.0 + np.abs(data.prescribed), np.abs(m.S) @ np.abs(T1)),
            ]
        )
        scale[: m.n_q] += m.masses * (np.abs(dq) + np.abs(data.p[: m.n_q]))
        forces, sizes, _ = m.motion_forces(*self._bracket(data, r), data.times)
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
        ends, times, half = self._bracket(data, r), data.times, 0.5 * data.times.dt / data.r
        _, _, slope_1 = m.motion_forces(*ends, times)
        if slope_1 is not None:
            # a step backwards has the same forces: the derivative with respect to its start
            back = StepTimes(-times.dt, times.middle, times.middle)
            _, _, slope_0 = m.motion_forces(*ends[::-1], back)
            assert slope_0 is not None
            K[:n, :n] -= data.s * ((1.0 - half) * slope_0 + (1.0 + half) * slope_1)
        return K

    def is_acceptable(self, data: EndData, r: Array) -> bool:
        """Whether angles lie on the right branch and redundant constraints hold."""
        _, _, q1, T1 = self._unknowns(data, r)
        return self.model.is_acceptable(q1, T1, self.model.split(r).dT)

    def _unknowns(self, data: EndData, r: Array) -> tuple[Array, Array, Array, Array]:
        """dq, the multipliers, and q and T at the end of the step."""
        n, dy = data.y.size, r[: data.y.size]
        y1 = data.y + dy
        return dy[: data.n_q], r[n:], y1[: data.n_q], y1[data.n_q :]

    def _bracket(self, data: EndData, r: Array) -> tuple[Array, Array]:
        """Two configurations h apart with y_{n+1} between them, moving as the end does.

        The forces' mean over the step between them is their force at the end, except for
        O(h^2).
        """
        dy = r[: data.y.size]
        way = 0.5 * data.times.dt * (dy / data.r + data.w)
        return data.y + dy - way, data.y + dy + way


class FlexibleEnd(MemorylessStep):
    """Equations of motion of a flexible body at the end of a step.

    Attributes:
        round_off: This rank's sum of the squares of the round-off of the residual.
        midpoint: Works of forces, and what dissipates in this body.
    """

    def __init__(self, model: FlexibleModel, gravity: Array) -> None:
        self.model = model
        mesh, V = model.body.mesh, model.space
        self._u_n, self._du, self._p, self._w = (fem.Function(V) for _ in range(4))
        self._s, self._rate, self._dt = (fem.Constant(mesh, 1.0) for _ in range(3))
        self._gravity = fem.Constant(mesh, gravity)
        test, delta = ufl.TestFunction(V), ufl.TrialFunction(V)
        u, v = self._u_n + self._du, self._rate * self._du + self._w
        R = model.inertia_term(self._du - self._p - self._s * self._gravity, test)
        R += self._s * model.virtual_work(u, v, test)
        self._residual = LinearForm(R)
        self._tangent = _compat.compile_form(ufl.derivative(R, self._du, delta))
        self.midpoint = MidpointWorks(model, self._u_n, self._du, self._dt, {})
        self.tangent = _compat.create_matrix(self._tangent)
        self._round_off = self._estimate_round_off()
        self._masses = np.repeat(model.weights, 3)
        self._fixed_terms, self.round_off, self._end = np.zeros_like(self._masses), 0.0, 0.0

    def start_step(
        self, u: PETSc.Vec, p: Array, w: Array, s: float, r: float, times: StepTimes
    ) -> None:
        """Set u_n, p, w, s, r and the step, whose forces act at its end."""
        model = self.model
        model.copy_to(self._u_n, u)
        for function, values in ((self._p, p), (self._w, w)):
            function.x.array[: values.size] = values
            function.x.scatter_forward()
        self._s.value, self._rate.value = s, 1.0 / r
        model.set_time(times.end)
        self._end = times.end
        self.midpoint.start_step(StepTimes.from_start(times.end - times.dt, times.dt))
        self.round_off = s * s * self._round_off.square(p, r)
        self._fixed_terms = self._masses * (np.abs(p) + s * np.linalg.norm(self._gravity.value))

    def residual(self, du: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble R_u for the increment du into R."""
        self.model.copy_to(self._du, du)
        self.model.assemble(self._residual, R)
        for dofs, force in self.model.nodal_forces:
            R.array[dofs] -= float(self._s.value) * force
        if self.model.has_node_loads:
            n = 3 * self.model.n_owned
            u = self._u_n.x.array[:n] + du.array_r
            v = float(self._rate.value) * du.array_r + self._w.x.array[:n]
            self.model.add_forces(u, v, self._end, -float(self._s.value), R.array)

    def assemble_tangent(self, du: PETSc.Vec) -> None:
        """Assemble the derivative of R_u into `tangent`."""
        self.model.copy_to(self._du, du)
        _compat.assemble_matrix(self.tangent, self._tangent)

    def assemble_at_rest(self) -> None:
        """Assemble the tangent for du = 0 and w = 0."""
        w = self._w.x.array.copy()
        self._du.x.array[:] = self._w.x.array[:] = 0.0
        _compat.assemble_matrix(self.tangent, self._tangent)
        self._w.x.array[:] = w

    def term_scale(self, du: PETSc.Vec) -> float:
        """This rank's sum of the squares of the inertia and gravity terms of R_u."""
        terms = self._masses * np.abs(du.array_r) + self._fixed_terms
        return float(np.dot(terms, terms))

    def set_middle(self, times: StepTimes) -> None:
        """Set the forces to the middle of the step, for `midpoint`."""
        self._dt.value = times.dt
        self.model.set_time(times.middle)

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


class EndStep(NestedStep):
    """Nested residual and tangent of one step of a scheme of the family.

    Args:
        system: The system.
    """

    frames = (1.0, 1.0)

    def __init__(self, system: MultibodySystem) -> None:
        gravity = system.gravity
        models = [on_mesh(model, "steps of the Newmark family") for model in system.flexible_models]
        self._flexible = tuple(FlexibleEnd(model, gravity) for model in models)
        super().__init__(system, self._flexible, RigidEnd(system.rigid_model))
        self._weight = system.gravity_force(gravity)
        self._ends = np.cumsum([3 * model.n_owned for model in system.flexible_models])

    def start_scheme(self, state: State, dt: float, end: float, scheme: EndScheme) -> None:
        """Set the state at t_n, the step [s], its end [s], and the scheme."""
        system, times = self.system, StepTimes(dt, end, end)
        load_q, load_T = (forces.sum(axis=0) for forces in system.evaluate_prescribed_forces(end))
        *p_bodies, p = self.split_flat(scheme.p)
        *w_bodies, w = self.split_flat(scheme.w)
        data = EndData(
            y=np.concatenate([state.q, state.joint_coordinates]),
            n_q=state.q.size,
            p=p,
            w=w,
            s=scheme.s,
            r=scheme.r,
            applied=np.concatenate([load_q + self._weight, load_T]),
            prescribed=system.relation_values(end),
            paths=system.paths.values(end),
            times=times,
        )
        for f, u, p_k, w_k in zip(self._flexible, state.u, p_bodies, w_bodies, strict=True):
            f.start_step(u, p_k, w_k, scheme.s, scheme.r, times)
        self.set_start(state, dt, data)

    def set_increments(self, dy: Array, state: State) -> None:
        """Set X to increments laid out like `EndScheme.p`, with the multipliers of a state."""
        *bodies, rigid = self.split_flat(dy)
        du, mu_c, r = self.split(self.x)
        for increment, values in zip(du, bodies, strict=True):
            increment.array[:] = values
        for mu, force in zip(mu_c, state.coupling, strict=True):
            force.copy(mu)
            mu.scale(self.rigid_data.s)
        if self.n_r:
            r.array[:] = np.concatenate([rigid, self.rigid_data.s * state.multipliers])

    def increments(self, x: PETSc.Vec) -> Array:
        """Increments in X, laid out like `EndScheme.p`. Collective."""
        du, _, r = self.split(x)
        rigid = self.on_all_ranks(r)[: self.rigid_data.y.size]
        return np.concatenate([*(part.array_r for part in du), rigid])

    def velocities(self, state: State) -> Array:
        """Velocities of a state, laid out like `EndScheme.p`."""
        return np.concatenate([*(v.array_r for v in state.v), state.q_dot, state.joint_rates])

    def split_flat(self, values: Array) -> list[Array]:
        """Parts of an array laid out like `EndScheme.p`: of each body, then of (q, T)."""
        return np.split(values, self._ends)

    def assemble_at_rest(self, body: int) -> None:
        """Assemble A_uu of a body at t_n for du = 0."""
        self._flexible[body].assemble_at_rest()

    def write_state(self, velocities: Array, drives: Array, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1}; returns works and losses by the midpoint rule. Collective.

        Args:
            velocities: Velocities at t_{n+1}, laid out like `EndScheme.p`.
            drives: Multipliers of what is `driven` at t_n.
            out: The state.
        """
        state, data, model = self.start.state, self.rigid_data, self.system.rigid_model
        du, mu_c, _ = self.split(self.x)
        r, n = self.rigid_unknowns(), data.y.size
        dq, dT = r[: data.n_q], r[data.n_q : n]
        *v, y_dot = self.split_flat(velocities)
        out.time, out.q, out.joint_coordinates = (
            data.times.end,
            state.q + dq,
            state.joint_coordinates + dT,
        )
        out.q_dot, out.joint_rates = y_dot[: data.n_q], y_dot[data.n_q :]
        out.multipliers = r[n:] / data.s
        for k, increment in enumerate(du):
            out.u[k].waxpy(1.0, state.u[k], increment)
            out.v[k].array[:] = v[k]
            mu_c[k].copy(out.coupling[k])
            out.coupling[k].scale(1.0 / data.s)
        middle = StepTimes.from_start(state.time, data.times.dt)
        load_q, load_T = self.system.evaluate_prescribed_forces(middle.middle)
        for f in self._flexible:
            f.set_middle(middle)
        means = 0.5 * (drives + out.multipliers[self.driven])
        return self.sum_works(
            np.asarray(load_q @ dq + load_T @ dT),
            model.motion_works(data.y, data.y + r[:n], middle),
            du,
            self.sum_drives(means, dq, dT),
        )
