"""The small global block of one energy-momentum step: rigid bodies, joints, joint angles.

Unknowns  r = (dq, dT, mu, nu): increments of the coordinates and of the joint angles, and the
multipliers of internal and joint constraints and of the angle constraints, each scaled by dt^2/2.
With q_{n+1} = q_n + dq and v_{n+1} = 2 dq/dt - v_n the step (21)-(24), (57)-(59) reads

    M (dq - dt v_n) + G(q_mid)^T mu + G_c(q_mid)^T g_c nu + G_s(q_mid)^T g_s nu = dt^2/2 F_q
                                                                       g_T nu   = dt^2/2 F_T
    Phi(q_{n+1})        = 0
    Phi_T(q_{n+1}, T_{n+1}) = 0

multiplied by dt^2/2, so that neither its condition nor its round-off grows as dt -> 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.joints.augmented_angle import AngleForm, AngleTerms, on_right_branch
from turbine_fenicsx.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.rotations import Array


class RigidUnknowns(NamedTuple):
    """The parts of r, each a 1D array."""

    dq: Array
    dT: Array
    mu: Array
    nu: Array


@dataclass(frozen=True)
class RigidStep:
    """Data of one step of the rigid block.

    Args:
        q: Coordinates q_n, shape (n_q,) [m, -].
        angles: Joint angles Theta_n, shape (n_T,) [rad].
        dt_q_dot: dt times the rates at t_n, shape (n_q,).
        impulse_q: dt^2/2 times the generalised force on q at t_{n+1/2}, shape (n_q,).
        impulse_T: dt^2/2 times the torque on the angles at t_{n+1/2}, shape (n_T,).
    """

    q: Array
    angles: Array
    dt_q_dot: Array
    impulse_q: Array
    impulse_T: Array


class _Evaluation(NamedTuple):
    """Functions of the unknowns: q_{n+1}, values y there, Jacobians at q_mid and q_{n+1}."""

    x: RigidUnknowns
    q1: Array
    y1: Array
    G: Array
    G1: Array
    a: AngleTerms
    lam: Array


class RigidBlock:
    """Residual and tangent of the rigid block; functions of the step and the unknowns alone.

    What residuals and tangents share is remembered for the step and the unknowns seen last.

    Args:
        masses: Diagonal of the mass matrix, shape (n_q,).
        constraints: Internal and joint constraints, quadratic in q.
        cosines: cos of each joint angle as a function of q.
        sines: sin of each joint angle as a function of q.
        angle_form: Form of the angle constraints.
    """

    def __init__(
        self,
        masses: Array,
        constraints: Sequence[Quadratic],
        cosines: Sequence[Quadratic],
        sines: Sequence[Quadratic],
        angle_form: AngleForm,
    ) -> None:
        """Compile the functions."""
        self.masses = masses
        self.angle_form = angle_form
        n_q, n_g, n_T = masses.size, len(constraints), len(cosines)
        self._map = QuadraticMap([*constraints, *cosines, *sines], n_q)
        self._g, self._c, self._s = (
            slice(0, n_g),
            slice(n_g, n_g + n_T),
            slice(n_g + n_T, n_g + 2 * n_T),
        )
        ends = np.cumsum([n_q, n_T, n_g, n_T])
        self._parts = [slice(e - n, e) for e, n in zip(ends, (n_q, n_T, n_g, n_T), strict=True)]
        self.size = int(ends[-1])
        self.n_q, self.n_angles, self.n_constraints = n_q, n_T, n_g
        self._mass_matrix = np.zeros((self.size, self.size))
        np.fill_diagonal(self._mass_matrix[:n_q, :n_q], masses)
        self._start: tuple[RigidStep | None, Array, Array] = (None, np.zeros(0), np.zeros(0))
        self._last: tuple[Array, _Evaluation | None] = (np.zeros(0), None)

    def split(self, r: Array) -> RigidUnknowns:
        """Views of the parts of r, shape (size,)."""
        return RigidUnknowns(*(r[part] for part in self._parts))

    def constraint_values(self, q: Array, angles: Array) -> Array:
        """All constraints (internal, joints, angles) at one configuration [m, -]."""
        y = self._map.value(q)
        angle = self.angle_form(angles, angles, y[self._c], y[self._c], y[self._s], y[self._s])
        return np.concatenate([y[self._g], angle.Phi])

    def residual(self, step: RigidStep, r: Array) -> tuple[Array, Array]:
        """Residual of the four equations and its scale.

        Args:
            step: Data of the step.
            r: Unknowns, shape (size,).

        Returns:
            The residual R, shape (size,), and the sum of the absolute values of its terms,
            shape (size,), which tells how small R can be made in floating point.
        """
        x, q1, y1, G, G1, a, lam = self._evaluate(step, r)
        R = np.concatenate(
            [
                self.masses * (x.dq - step.dt_q_dot) + lam @ G - step.impulse_q,
                a.g_T * x.nu - step.impulse_T,
                y1[self._g],
                a.Phi,
            ]
        )
        scale = np.concatenate(
            [
                self.masses * (np.abs(x.dq) + np.abs(step.dt_q_dot))
                + np.abs(lam) @ np.abs(G)
                + np.abs(step.impulse_q),
                np.abs(a.g_T * x.nu) + np.abs(step.impulse_T),
                np.abs(self._map.constant[self._g]) + np.abs(G1[self._g]) @ np.abs(q1),
                np.abs(y1[self._c]) + np.abs(y1[self._s]),
            ]
        )
        return R, scale

    def tangent(self, step: RigidStep, r: Array) -> Array:
        """Derivative of the residual with respect to r, shape (size, size)."""
        x, _, _, G, G1, a, lam = self._evaluate(step, r)
        K = self._mass_matrix.copy()
        q, T, mu, nu = self._parts
        K[q, q] += 0.5 * self._map.hessian(lam)
        K[q, T] = (
            (a.g_c_T * x.nu)[:, None] * G[self._c] + (a.g_s_T * x.nu)[:, None] * G[self._s]
        ).T
        K[q, mu] = G[self._g].T
        K[q, nu] = (a.g_c[:, None] * G[self._c] + a.g_s[:, None] * G[self._s]).T
        K[T, q] = (x.nu * a.g_T_c)[:, None] * G1[self._c] + (x.nu * a.g_T_s)[:, None] * G1[self._s]
        K[T, T] = np.diag(a.g_T_T * x.nu)
        K[T, nu] = np.diag(a.g_T)
        K[mu, q] = G1[self._g]
        K[nu, q] = a.Phi_c[:, None] * G1[self._c] + a.Phi_s[:, None] * G1[self._s]
        K[nu, T] = np.diag(a.Phi_T)
        return K

    def _evaluate(self, step: RigidStep, r: Array) -> _Evaluation:
        """Everything that residual and tangent have in common."""
        if self._start[0] is not step:
            G0 = self._map.jacobian(step.q)
            self._start = (step, G0, self._map.value(step.q, G0))
            self._last = (r, None)
        last_r, last = self._last
        if last is not None and np.array_equal(last_r, r):
            return last
        _, G0, y0 = self._start
        r = r.copy()
        x = self.split(r)
        q1, T1 = step.q + x.dq, step.angles + x.dT
        G1 = self._map.jacobian(q1)
        y1 = self._map.value(q1, G1)
        a = self.angle_form(step.angles, T1, y0[self._c], y1[self._c], y0[self._s], y1[self._s])
        lam = np.concatenate([x.mu, a.g_c * x.nu, a.g_s * x.nu])
        found = _Evaluation(x, q1, y1, 0.5 * (G0 + G1), G1, a, lam)
        self._last = (r, found)
        return found

    def acceptable(self, step: RigidStep, r: Array) -> bool:
        """Whether the joint angles of a solution lie on the right branch."""
        x = self.split(r)
        y1 = self._map.value(step.q + x.dq)
        return on_right_branch(x.dT, step.angles + x.dT, y1[self._c], y1[self._s])
