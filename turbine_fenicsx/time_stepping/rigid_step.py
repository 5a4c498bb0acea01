"""Rigid bodies, joints and joint coordinates in one energy-momentum step.

The unknowns are r = (dq, dT, mu, nu, pi). dq and dT are increments of the coordinates and of the
joint coordinates. The multipliers mu of internal and joint constraints, nu of joint coordinates and
pi of their relations are scaled by dt^2/2. With q_{n+1} = q_n + dq and v_{n+1} = 2 dq/dt - v_n the
step (21)-(24), (57)-(59) reads

    M (dq - dt v_n) + G(q_mid)^T mu + G_c(q_mid)^T g_c nu + G_s(q_mid)^T g_s nu = dt^2/2 F_q
                                                              g_T nu + S^T pi   = dt^2/2 F_T
    Phi(q_{n+1})            = p(t_{n+1})
    Phi_T(q_{n+1}, T_{n+1}) = 0
    S T_{n+1} - p(t_{n+1})  = 0

multiplied by dt^2/2, so that neither its condition nor its round-off grows as dt -> 0. F_q and F_T
hold the forces.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.memo import Memo
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import AngleForm, AngleTerms
from turbine_fenicsx.joints.coordinates import augmentation
from turbine_fenicsx.system.rigid_model import NOTHING, RigidModel, RigidUnknowns


@dataclass(frozen=True)
class RigidData:
    """Input of a step of the rigid part.

    Args:
        q: Coordinates q_n, shape (n_q,) [m, -].
        T: Joint coordinates Theta_n, shape (n_T,) [rad, m].
        dt_q_dot: dt times the rates at t_n, shape (n_q,).
        impulse_q: dt^2/2 times the generalised force on q at t_{n+1/2}, shape (n_q,).
        impulse_T: dt^2/2 times the torque on the joint coordinates at t_{n+1/2}, shape (n_T,).
        prescribed: p(t_{n+1}) of the relations, shape (n_p,).
        paths: Right-hand sides of the constraints at t_{n+1}, as of `Paths`; zero if left out.
        times: Length, middle and end of the step.
    """

    q: Array
    T: Array
    dt_q_dot: Array
    impulse_q: Array
    impulse_T: Array
    prescribed: Array = field(default_factory=lambda: np.zeros(0))
    paths: Array = field(default_factory=lambda: np.zeros(1))
    times: StepTimes = field(default_factory=lambda: StepTimes.from_start(0.0, 1.0))


class _Start(NamedTuple):
    """Constants of a step: Jacobian G and values y at q_n, |G|, and sizes of terms.

    The sizes, shape (size,), are those of all terms that the unknowns do not change by more than
    a part of them.
    """

    G: Array
    y: Array
    abs_G: Array
    sizes: Array


class _Evaluation(NamedTuple):
    """Functions of the unknowns: T_{n+1}, values y there, Jacobians at q_mid and q_{n+1}."""

    start: _Start
    x: RigidUnknowns
    T1: Array
    y1: Array
    G: Array
    G1: Array
    a: AngleTerms
    lam: Array
    forces: Array
    forces_scale: Array
    slope: Array | None


class RigidStep:
    """Residual and tangent of the rigid part; functions of the data and the unknowns alone.

    Args:
        angle_form: Form of the angle constraints and its discrete gradient.
    """

    def __init__(self, model: RigidModel, angle_form: AngleForm) -> None:
        self.model = model
        self._terms = augmentation(angle_form, model.is_angle)
        self._start = Memo(self._begin)
        self._at = Memo(self._evaluate)

    def residual(self, data: RigidData, r: Array) -> tuple[Array, Array]:
        """Residual of the equations and its scale.

        Args:
            r: Unknowns, shape (size,).

        Returns:
            The residual R, shape (size,), and the sum of the absolute values of its terms,
            shape (size,), which limits how small R can become in floating point. Factors that
            hardly change in a step are those at its start.
        """
        m = self.model
        start, x, T1, y1, G, _, a, lam, forces, forces_scale, _ = self._at(data, r)
        g_T_nu = a.g_T * x.nu
        R, scale = np.empty(m.size), start.sizes.copy()
        q, T, mu, nu, pi = m.parts
        # momenta of the bodies, eqs (21), (57)
        R[q] = m.masses * (x.dq - data.dt_q_dot) + lam @ G - data.impulse_q
        scale[q] += m.masses * np.abs(x.dq) + np.abs(lam) @ start.abs_G
        # balance of the massless joint coordinates, eqs (22), (58)
        R[T] = g_T_nu - data.impulse_T
        scale[T] += np.abs(g_T_nu)
        # internal and joint constraints, eqs (23), (59), and joint coordinates, eq. (24)
        R[mu], R[nu] = y1[m.g] - data.paths[m.g], a.Phi
        if m.n_relations:
            R[T] += x.pi @ m.S
            scale[T] += np.abs(x.pi) @ np.abs(m.S)
            R[pi] = m.S @ T1 - data.prescribed
        if m.forces:
            R[: forces.size] -= forces
            scale[: forces.size] += forces_scale
        return R, scale

    def tangent(self, data: RigidData, r: Array) -> Array:
        """Derivative of the residual with respect to r, shape (size, size)."""
        m = self.model
        _, x, _, _, G, G1, a, lam, _, _, slope = self._at(data, r)
        K = np.zeros((m.size, m.size))
        q, T, mu, nu, pi = m.parts
        G_c, G_s, G1_c, G1_s = G[m.c].T, G[m.s].T, G1[m.c].T, G1[m.s].T
        K[q, q] = m.mass_matrix + m.functions.hessian(0.5 * lam)
        K[q, T] = G_c * (a.g_c_T * x.nu) + G_s * (a.g_s_T * x.nu)
        K[q, mu] = G[m.g].T
        K[q, nu] = G_c * a.g_c + G_s * a.g_s
        K[T, q] = (G1_c * (a.g_T_c * x.nu) + G1_s * (a.g_T_s * x.nu)).T
        K[T, T] = np.diag(a.g_T_T * x.nu)
        K[T, nu] = np.diag(a.g_T)
        K[mu, q] = G1[m.g]
        K[nu, q] = (G1_c * a.Phi_c + G1_s * a.Phi_s).T
        K[nu, T] = np.diag(a.Phi_T)
        if m.n_relations:
            K[pi, T], K[T, pi] = m.S, m.S.T
        if slope is not None:
            K[: len(slope), : len(slope)] -= slope
        return K

    def motion_works(self, data: RigidData, r: Array) -> Array:
        """Work of each force [J]: exactly force times increment."""
        return self.model.motion_works(*self._ends(data, self.model.split(r)), data.times)

    def is_acceptable(self, data: RigidData, r: Array) -> bool:
        """Whether angles lie on the right branch and redundant constraints hold."""
        x = self.model.split(r)
        return self.model.is_acceptable(data.q + x.dq, data.T + x.dT, x.dT)

    def constraint_forces(
        self, q0: Array, T0: Array, q1: Array, T1: Array, multipliers: Array
    ) -> tuple[Array, Array]:
        """Forces of constraints and joint coordinates in a step.

        Args:
            q0: Coordinates at its start, shape (n_q,).
            T0: Joint coordinates there, shape (n_T,).
            multipliers: Those of the step, as in `State`.

        Returns:
            As `RigidModel.constraint_forces`, in the middle of the step.
        """
        m = self.model
        (_, y1), y0 = m.at(q1), m.functions.value(q0)
        a = self._terms(T0, T1, y0[m.c], y1[m.c], y0[m.s], y1[m.s])
        mu, nu = multipliers[m.g], multipliers[m.c]
        return np.concatenate([mu, a.g_c * nu, a.g_s * nu]), m.functions.jacobian(0.5 * (q0 + q1))

    def _evaluate(self, data: RigidData, r: Array) -> _Evaluation:
        """Everything that residual and tangent have in common."""
        m = self.model
        start = self._start(data)
        y0, x = start.y, m.split(r.copy())
        q1, T1 = data.q + x.dq, data.T + x.dT
        G1, y1 = m.at(q1)
        a = self._terms(data.T, T1, y0[m.c], y1[m.c], y0[m.s], y1[m.s])
        lam = np.concatenate([x.mu, a.g_c * x.nu, a.g_s * x.nu])
        forces, sizes, slope = NOTHING, NOTHING, None
        if m.forces:
            forces, sizes, slope = m.motion_forces(*self._ends(data, x), data.times)
        if slope is not None:  # dt^2/2 times the forces that depend on the motion
            forces, sizes, slope = (data.times.half_dt2 * y for y in (forces, sizes, slope))
        G = 0.5 * (start.G + G1)
        return _Evaluation(start, x, T1, y1, G, G1, a, lam, forces, sizes, slope)

    def _begin(self, data: RigidData) -> _Start:
        """Quantities that are constant in a step.

        An angle itself is among the terms of its constraint: after many turns its round-off is
        what is left.
        """
        m, q, T = self.model, np.abs(data.q), np.abs(data.T)
        G, y = m.at(data.q)
        abs_G = np.abs(G)
        terms = np.abs(m.functions.constant) + abs_G @ q
        angle = np.abs(y[m.c]) + np.abs(y[m.s]) + T
        sizes = [
            m.masses * np.abs(data.dt_q_dot) + np.abs(data.impulse_q),
            np.abs(data.impulse_T),
            terms[m.g],
            np.where(m.is_angle, angle, terms[m.c]),
            np.maximum(1.0 + np.abs(data.prescribed), np.abs(m.S) @ T),
        ]
        return _Start(G, y, abs_G, np.concatenate(sizes))

    def _ends(self, data: RigidData, x: RigidUnknowns) -> tuple[Array, Array]:
        """Coordinates (q, Theta) at both ends of the step."""
        y0 = np.concatenate([data.q, data.T])
        return y0, y0 + np.concatenate([x.dq, x.dT])
