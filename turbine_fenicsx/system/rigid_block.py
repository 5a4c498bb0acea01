"""The small global block of one energy-momentum step: rigid bodies, joints, joint coordinates.

Unknowns  r = (dq, dT, mu, nu, pi): increments of the coordinates and of the joint coordinates, and
the multipliers of internal and joint constraints, of the constraints of the joint coordinates and
of prescribed motions, each scaled by dt^2/2. With q_{n+1} = q_n + dq and v_{n+1} = 2 dq/dt - v_n
the step (21)-(24), (57)-(59) reads

    M (dq - dt v_n) + G(q_mid)^T mu + G_c(q_mid)^T g_c nu + G_s(q_mid)^T g_s nu = dt^2/2 F_q
                                                              g_T nu + S^T pi   = dt^2/2 F_T
    Phi(q_{n+1})            = 0
    Phi_T(q_{n+1}, T_{n+1}) = 0
    S T_{n+1} - p(t_{n+1})  = 0

multiplied by dt^2/2, so that neither its condition nor its round-off grows as dt -> 0. S selects
the joint coordinates with a prescribed motion; F_q and F_T hold the loads and the force elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.element import BoundElement, Step
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import AngleForm, AngleTerms, on_right_branch
from turbine_fenicsx.joints.coordinates import Angle, JointCoordinate, augmentation


class RigidUnknowns(NamedTuple):
    """The parts of r, each a 1D array."""

    dq: Array
    dT: Array
    mu: Array
    nu: Array
    pi: Array


_NOTHING: Array = np.zeros(0)

REDUNDANT_GAP = 1e-6
"""A step that opens a redundant constraint further than this [m, -] is not accepted."""


@dataclass(frozen=True)
class RigidStep:
    """Data of one step of the rigid block.

    Args:
        q: Coordinates q_n, shape (n_q,) [m, -].
        angles: Joint coordinates Theta_n, shape (n_T,) [rad, m].
        dt_q_dot: dt times the rates at t_n, shape (n_q,).
        impulse_q: dt^2/2 times the generalised force on q at t_{n+1/2}, shape (n_q,).
        impulse_T: dt^2/2 times the torque on the angles at t_{n+1/2}, shape (n_T,).
        prescribed: p(t_{n+1}) of the prescribed motions, shape (n_p,).
        elements: Length and middle of the step, for force elements.
    """

    q: Array
    angles: Array
    dt_q_dot: Array
    impulse_q: Array
    impulse_T: Array
    prescribed: Array = field(default_factory=lambda: np.zeros(0))
    elements: Step = field(default_factory=lambda: Step(1.0, 0.0))


class _Evaluation(NamedTuple):
    """Functions of the unknowns: q_{n+1}, values y there, Jacobians at q_mid and q_{n+1}."""

    x: RigidUnknowns
    q1: Array
    T1: Array
    y1: Array
    G: Array
    G1: Array
    a: AngleTerms
    lam: Array
    forces: Array
    forces_scale: Array
    stiffness: Array | None


class RigidBlock:
    """Residual and tangent of the rigid block; functions of the step and the unknowns alone.

    What residuals and tangents share is remembered for the step and the unknowns seen last, and the
    values of all functions for the configuration seen last: the end of a step is the next start.

    Args:
        masses: Diagonal of the mass matrix, shape (n_q,).
        constraints: Internal and joint constraints, quadratic in q.
        coordinates: The joint coordinates as functions of q.
        angle_form: Form of the angle constraints.
        prescribed: Which joint coordinates have a prescribed motion, shape (n_p,).
        elements: Force elements.
        redundant: Which constraints depend on the others; they have no multiplier and are only
            watched.

    Attributes:
        n_q: Number of coordinates of rigid bodies.
        n_angles: Number of joint coordinates.
        is_angle: Which of them are angles, shape (n_angles,).
        n_constraints: Number of internal and joint constraints with a multiplier.
        n_prescribed: Number of prescribed motions.
        n_rows: Number of functions of q: constraints, then two for each joint coordinate.
        size: Number of unknowns.
    """

    def __init__(
        self,
        masses: Array,
        constraints: Sequence[Quadratic],
        coordinates: Sequence[JointCoordinate],
        angle_form: AngleForm,
        prescribed: Sequence[int] = (),
        elements: Sequence[BoundElement] = (),
        redundant: npt.ArrayLike = (),
    ) -> None:
        """Compile the functions."""
        self.masses, self.elements = masses, tuple(elements)
        self.is_angle = np.array([isinstance(c, Angle) for c in coordinates], dtype=bool)
        self.angle_form = augmentation(angle_form, self.is_angle)
        left_out = set(np.asarray(redundant, dtype=int).tolist())
        kept = [c for k, c in enumerate(constraints) if k not in left_out]
        n_q, n_g, n_T, n_p = masses.size, len(kept), len(coordinates), len(prescribed)
        sines = [c.sine if isinstance(c, Angle) else Quadratic(0.0) for c in coordinates]
        self._map = QuadraticMap([*kept, *(c[0] for c in coordinates), *sines], n_q)
        self._redundant = QuadraticMap([constraints[k] for k in sorted(left_out)], n_q)
        self._g, self._c, self._s = (
            slice(0, n_g),
            slice(n_g, n_g + n_T),
            slice(n_g + n_T, n_g + 2 * n_T),
        )
        self.n_rows = n_g + 2 * n_T
        sizes = (n_q, n_T, n_g, n_T, n_p)
        ends = np.cumsum(sizes)
        self._parts = [slice(e - n, e) for e, n in zip(ends, sizes, strict=True)]
        self.size = int(ends[-1])
        self.n_q, self.n_angles, self.n_constraints, self.n_prescribed = n_q, n_T, n_g, n_p
        self._prescribed = np.array(prescribed, dtype=np.int64)
        self._selection = np.eye(n_T)[self._prescribed]
        self._mass_matrix = np.diag(masses)
        self._seen: tuple[Array, Array, Array] | None = None
        self._start: tuple[RigidStep | None, Array, Array] = (None, np.zeros(0), np.zeros(0))
        self._last: tuple[Array, _Evaluation | None] = (np.zeros(0), None)

    def split(self, r: Array) -> RigidUnknowns:
        """Views of the parts of r, shape (size,)."""
        return RigidUnknowns(*(r[part] for part in self._parts))

    def constraint_values(self, q: Array, angles: Array) -> Array:
        """All constraints (internal, joints, coordinates) at one configuration [m, -]."""
        (_, y), (_, last) = self._at(q), self._last
        if last is not None and _same(q, last.q1) and _same(angles, last.T1):
            Phi = last.a.Phi
        else:
            c, s = y[self._c], y[self._s]
            Phi = self.angle_form(angles, angles, c, c, s, s).Phi
        return np.concatenate([y[self._g], Phi, self._gaps(q)])

    def velocity_rows(self, q: Array) -> tuple[Array, Array]:
        """Gradients of the constraints, and of the joint coordinates where these are zero.

        Returns:
            Shapes (n_constraints, n_q) and (n_angles, n_q).
        """
        G = self._map.jacobian(q)
        return G[self._g], np.where(self.is_angle[:, None], G[self._s], G[self._c])

    def forces_between(
        self, q0: Array, T0: Array, q1: Array, T1: Array, multipliers: Array
    ) -> tuple[Array, Array]:
        """Forces of constraints and joint coordinates in a step.

        Args:
            q0: Coordinates at its start, shape (n_q,).
            T0: Joint coordinates there, shape (n_angles,).
            q1: Coordinates at its end.
            T1: Joint coordinates there.
            multipliers: Those of the step, as in `State`.

        Returns:
            Factors lambda, shape (n_rows,), and gradients G in the middle of the step, shape
            (n_rows, n_q), of the constraints with a multiplier, then of the cosines (displacements)
            and of the sines of all joint coordinates; -lambda_k G_k is the force of row k on q.
        """
        (_, y1), y0 = self._at(q1), self._map.value(q0)
        a = self.angle_form(T0, T1, y0[self._c], y1[self._c], y0[self._s], y1[self._s])
        mu, nu = multipliers[self._g], multipliers[self._c]
        return np.concatenate([mu, a.g_c * nu, a.g_s * nu]), self._map.jacobian(0.5 * (q0 + q1))

    def element_works(self, step: RigidStep, r: Array) -> Array:
        """Work of each force element in a step [J]: exactly force times increment."""
        if not self.elements:
            return _NOTHING
        y0, y1 = self._both(step, self.split(r))
        works = []
        for e in self.elements:
            start, end = y0[e.index], y1[e.index]
            works.append(float(e.force(start, end, step.elements)[0] @ (end - start)))
        return np.array(works)

    def element_energy(self, q: Array, angles: Array) -> float:
        """Energy of all conservative force elements [J]."""
        if not self.elements:
            return 0.0
        y = np.concatenate([q, angles])
        return sum(e.energy(y[e.index]) for e in self.elements)

    def residual(self, step: RigidStep, r: Array) -> tuple[Array, Array]:
        """Residual of the four equations and its scale.

        Args:
            step: Data of the step.
            r: Unknowns, shape (size,).

        Returns:
            The residual R, shape (size,), and the sum of the absolute values of its terms,
            shape (size,), which tells how small R can be made in floating point.
        """
        x, q1, T1, y1, G, G1, a, lam, forces, forces_scale, _ = self._evaluate(step, r)
        g_T_nu = a.g_T * x.nu
        R = np.concatenate(
            [
                self.masses * (x.dq - step.dt_q_dot) + lam @ G - step.impulse_q,
                g_T_nu - step.impulse_T,
                y1[self._g],
                a.Phi,
                T1[self._prescribed] - step.prescribed,
            ]
        )
        scale = np.concatenate(
            [
                self.masses * (np.abs(x.dq) + np.abs(step.dt_q_dot))
                + np.abs(lam) @ np.abs(G)
                + np.abs(step.impulse_q),
                np.abs(g_T_nu) + np.abs(step.impulse_T),
                np.abs(self._map.constant[self._g]) + np.abs(G1[self._g]) @ np.abs(q1),
                self._coordinate_scale(T1, q1, y1, G1),
                1.0 + np.abs(step.prescribed),
            ]
        )
        if self.elements:
            R[: forces.size] -= forces
            scale[: forces.size] += forces_scale
        if self.n_prescribed:
            T = self._parts[1]
            R[T] += x.pi @ self._selection
            scale[T] += np.abs(x.pi) @ self._selection
        return R, scale

    def tangent(self, step: RigidStep, r: Array) -> Array:
        """Derivative of the residual with respect to r, shape (size, size)."""
        x, _, _, _, G, G1, a, lam, _, _, stiffness = self._evaluate(step, r)
        K = np.zeros((self.size, self.size))
        q, T, mu, nu, pi = self._parts
        G_c, G_s, G1_c, G1_s = G[self._c].T, G[self._s].T, G1[self._c].T, G1[self._s].T
        K[q, q] = self._mass_matrix + self._map.hessian(0.5 * lam)
        K[q, T] = G_c * (a.g_c_T * x.nu) + G_s * (a.g_s_T * x.nu)
        K[q, mu] = G[self._g].T
        K[q, nu] = G_c * a.g_c + G_s * a.g_s
        K[T, q] = (G1_c * (a.g_T_c * x.nu) + G1_s * (a.g_T_s * x.nu)).T
        K[T, T] = np.diag(a.g_T_T * x.nu)
        K[T, nu] = np.diag(a.g_T)
        K[mu, q] = G1[self._g]
        K[nu, q] = (G1_c * a.Phi_c + G1_s * a.Phi_s).T
        K[nu, T] = np.diag(a.Phi_T)
        if self.n_prescribed:
            K[pi, T], K[T, pi] = self._selection, self._selection.T
        if stiffness is not None:
            K[: len(stiffness), : len(stiffness)] -= stiffness
        return K

    def _evaluate(self, step: RigidStep, r: Array) -> _Evaluation:
        """Everything that residual and tangent have in common."""
        if self._start[0] is not step:
            self._start = (step, *self._at(step.q))
            self._last = (r, None)
        (last_r, last), r = self._last, r.copy()
        if last is not None and _same(last_r, r):
            return last
        _, G0, y0 = self._start
        x = self.split(r)
        q1, T1 = step.q + x.dq, step.angles + x.dT
        G1, y1 = self._at(q1)
        a = self.angle_form(step.angles, T1, y0[self._c], y1[self._c], y0[self._s], y1[self._s])
        lam = np.concatenate([x.mu, a.g_c * x.nu, a.g_s * x.nu])
        forces = self._element_forces(step, x)
        found = _Evaluation(x, q1, T1, y1, 0.5 * (G0 + G1), G1, a, lam, *forces)
        self._last = (r, found)
        return found

    def _at(self, q: Array) -> tuple[Array, Array]:
        """Jacobian and values of all functions at a configuration."""
        if self._seen is None or not _same(q, self._seen[0]):
            G = self._map.jacobian(q)
            self._seen = (q.copy(), G, self._map.value(q, G))
        return self._seen[1:]

    def _coordinate_scale(self, T1: Array, q1: Array, y1: Array, G1: Array) -> Array:
        """Sizes of the terms of the constraints of joint coordinates, shape (n_T,).

        The angle itself is one of them: after many turns its round-off is what is left.
        """
        angle = np.abs(y1[self._c]) + np.abs(y1[self._s]) + np.abs(T1)
        if np.all(self.is_angle):
            return angle
        length = np.abs(self._map.constant[self._c]) + np.abs(G1[self._c]) @ np.abs(q1)
        return np.where(self.is_angle, angle, length)

    def _both(self, step: RigidStep, x: RigidUnknowns) -> tuple[Array, Array]:
        """Coordinates (q, Theta) at both ends of the step."""
        y0 = np.concatenate([step.q, step.angles])
        return y0, y0 + np.concatenate([x.dq, x.dT])

    def _element_forces(
        self, step: RigidStep, x: RigidUnknowns
    ) -> tuple[Array, Array, Array | None]:
        """dt^2/2 times the forces of all elements, their sizes and their derivatives."""
        if not self.elements:
            return _NOTHING, _NOTHING, None
        n = self.n_q + self.n_angles
        forces, sizes = np.zeros(n), np.zeros(n)
        factor = 0.5 * step.elements.dt**2
        stiffness = np.zeros((n, n))
        y0, y1 = self._both(step, x)
        for e in self.elements:
            F, K = e.force(y0[e.index], y1[e.index], step.elements)
            forces[e.index] += factor * F
            sizes[e.index] += np.abs(factor * F)
            stiffness[np.ix_(e.index, e.index)] += factor * K
        return forces, sizes, stiffness

    def acceptable(self, step: RigidStep, r: Array) -> bool:
        """Whether angles lie on the right branch and redundant constraints hold."""
        x = self.split(r)
        q1 = step.q + x.dq
        (_, y1), k = self._at(q1), self.is_angle
        angles = on_right_branch(x.dT[k], (step.angles + x.dT)[k], y1[self._c][k], y1[self._s][k])
        return angles and bool(np.all(np.abs(self._gaps(q1)) <= REDUNDANT_GAP))

    def _gaps(self, q: Array) -> Array:
        """Values of the redundant constraints."""
        return self._redundant.value(q) if self._redundant.shape[0] else _NOTHING


def _same(a: Array, b: Array) -> bool:
    """Whether two arrays are equal bit for bit; faster for small ones than `np.array_equal`."""
    return a.tobytes() == b.tobytes()
