"""Rigid bodies, joints, joint coordinates and their relations as functions of a configuration.

The coordinates y = (q, T) are those of the rigid bodies and the joint coordinates. With the
multipliers (mu, nu, pi) the equations of motion and the constraints are

    M q'' + G^T mu + (Phi_T,q)^T nu         = F_q(y, y', t)
                      Phi_T,T nu  + S^T pi  = F_T(y, y', t)
    Phi(q) = 0,   Phi_T(q, T) = 0,   S T - p(t) = 0.

Phi holds the internal constraints of the bodies and those of the joints, all quadratic in q. Phi_T
ties each joint coordinate to its functions of q (`joints.augmented_angle`). The rows of S are
prescribed motions and other relations of joint coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.force import BoundForce, StepTimes, evaluate_force
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.memo import Memo
from turbine_fenicsx.foundation.own_code import name_errors
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import AngleTerms, on_right_branch, regular
from turbine_fenicsx.joints.coordinates import Angle, JointCoordinate, augmentation

NOTHING: Array = np.zeros(0)

REDUNDANT_GAP = 1e-6
"""A step that opens a redundant constraint further than this [m, -] is not accepted."""


class RigidUnknowns(NamedTuple):
    """The parts of the rigid unknowns r, each a 1D array."""

    dq: Array
    dT: Array
    mu: Array
    nu: Array
    pi: Array


class RigidModel:
    """The rigid part of a system, without a time step.

    Args:
        masses: Diagonal of the mass matrix M, shape (n_q,).
        constraints: Internal and joint constraints, quadratic in q.
        coordinates: The joint coordinates as functions of q.
        relations: S, one row for each relation of joint coordinates, shape (n_p, n_T).
        forces: Forces that depend on the motion.
        redundant: Which constraints depend on the others; they have no multiplier and are only
            watched.

    Attributes:
        n_q: Number of coordinates of rigid bodies.
        n_T: Number of joint coordinates.
        is_angle: Which of them are T, shape (n_T,).
        n_constraints: Number of internal and joint constraints with a multiplier.
        n_relations: Number of relations.
        n_rows: Number of functions of q: constraints, then two for each joint coordinate.
        size: Number of unknowns.
        functions: Constraints, then cosines (displacements), then sines of all joint coordinates.
        g, c, s: Rows of these three in `functions`.
        parts: Slices of the unknowns r.
    """

    def __init__(
        self,
        masses: Array,
        constraints: Sequence[Quadratic],
        coordinates: Sequence[JointCoordinate],
        relations: Array | None = None,
        forces: Sequence[BoundForce] = (),
        redundant: npt.ArrayLike = (),
    ) -> None:
        self.masses, self.forces = masses, tuple(forces)
        self.is_angle = np.array([isinstance(c, Angle) for c in coordinates], dtype=bool)
        self._terms = augmentation(regular, self.is_angle)
        left_out = set(np.asarray(redundant, dtype=int).tolist())
        kept = [c for k, c in enumerate(constraints) if k not in left_out]
        n_q, n_g, n_T = masses.size, len(kept), len(coordinates)
        self.S = np.zeros((0, n_T)) if relations is None else relations
        sines = [c.sine if isinstance(c, Angle) else Quadratic(0.0) for c in coordinates]
        self.functions = QuadraticMap([*kept, *(c[0] for c in coordinates), *sines], n_q)
        self._redundant = QuadraticMap([constraints[k] for k in sorted(left_out)], n_q)
        self.g, self.c = slice(0, n_g), slice(n_g, n_g + n_T)
        self.s = slice(n_g + n_T, n_g + 2 * n_T)
        self.n_rows = n_g + 2 * n_T
        sizes = (n_q, n_T, n_g, n_T, len(self.S))
        ends = np.cumsum(sizes)
        self.parts = [slice(e - n, e) for e, n in zip(ends, sizes, strict=True)]
        self.size = int(ends[-1])
        self.n_q, self.n_T, self.n_constraints, _, self.n_relations = sizes
        self.mass_matrix = np.diag(masses)
        self.at = Memo(self._jacobian_and_values)

    def split(self, r: Array) -> RigidUnknowns:
        """Views of the parts of r, shape (size,)."""
        return RigidUnknowns(*map(r.__getitem__, self.parts))

    def constraint_values(self, q: Array, T: Array) -> Array:
        """Phi, Phi_T and the redundant constraints at a configuration [m, -]."""
        _, y = self.at(q)
        c, s = y[self.c], y[self.s]
        Phi_T = np.sin(T) * c - np.cos(T) * s
        if not np.all(self.is_angle):
            Phi_T = np.where(self.is_angle, Phi_T, T - c)
        return np.concatenate([y[self.g], Phi_T, self.gaps(q)])

    def constraint_jacobian(self, q: Array, T: Array) -> Array:
        """Gradients of Phi, Phi_T and S T, shape (n_constraints + n_T + n_relations, n_y)."""
        (G, _), a = self.at(q), self.angle_terms(q, T)
        n_g, n_T = self.n_constraints, self.n_T
        D = np.zeros((self.size - self.n_q - n_T, self.n_q + n_T))
        D[:n_g, : self.n_q] = G[self.g]
        D[n_g : n_g + n_T, : self.n_q] = a.g_c[:, None] * G[self.c] + a.g_s[:, None] * G[self.s]
        D[n_g : n_g + n_T, self.n_q :] = np.diag(a.g_T)
        D[n_g + n_T :, self.n_q :] = self.S
        return D

    def stiffness(self, q: Array, T: Array, multipliers: Array, time: float) -> Array:
        """Stiffness of constraints and forces, the derivative of `static_forces`.

        Args:
            q: Coordinates, shape (n_q,).
            T: Joint coordinates, shape (n_T,).
            multipliers: (mu, nu, pi).
            time: Time of the forces [s].

        Returns:
            Shape (n_q + n_T, n_q + n_T).
        """
        K, y = self.constraint_stiffness(q, T, multipliers), np.concatenate([q, T])
        _, _, slope = self.motion_forces(y, y, StepTimes.at_rest(time))
        return K if slope is None else K - 2.0 * slope  # the ends of a step count equally

    def damping(self, q: Array, T: Array, time: float) -> Array:
        """Derivative of minus the forces with respect to the velocity at rest.

        The slope of a force in a step is half that with respect to the configuration and that with
        respect to the rate (y1 - y0)/dt over dt; a step without end has the former alone.

        Args:
            q: Coordinates, shape (n_q,).
            T: Joint coordinates, shape (n_T,).
            time: Time of the forces [s].

        Returns:
            Shape (n_q + n_T, n_q + n_T).
        """
        y = np.concatenate([q, T])
        _, _, moving = self.motion_forces(y, y, StepTimes(1.0, time, time))
        _, _, resting = self.motion_forces(y, y, StepTimes.at_rest(time))
        if moving is None or resting is None:
            return np.zeros((y.size, y.size))
        return resting - moving

    def constraint_stiffness(self, q: Array, T: Array, multipliers: Array) -> Array:
        """Derivative of the constraint forces at constant multipliers, as in `stiffness`."""
        (G, _), a, n = self.at(q), self.angle_terms(q, T), self.n_q
        mu, nu = multipliers[self.g], multipliers[self.c]
        # The factors g of a step are symmetric in its ends: d/dT of the limit is twice d/dT_1.
        mixed = 2.0 * nu[:, None] * (a.g_c_T[:, None] * G[self.c] + a.g_s_T[:, None] * G[self.s])
        K = np.zeros((n + self.n_T,) * 2)
        K[:n, :n] = self.functions.hessian(np.concatenate([mu, a.g_c * nu, a.g_s * nu]))
        K[n:, :n], K[:n, n:] = mixed, mixed.T
        K[n:, n:] = np.diag(2.0 * nu * a.g_T_T)
        return K

    def static_forces(
        self, q: Array, T: Array, multipliers: Array, time: float, prescribed: Array
    ) -> Array:
        """Forces that (q, T) lack for equilibrium, those of constraints minus applied forces.

        Args:
            q: Coordinates, shape (n_q,).
            T: Joint coordinates, shape (n_T,).
            multipliers: (mu, nu, pi).
            time: Time of the forces [s].
            prescribed: All prescribed forces on (q, T), shape (n_q + n_T,).
        """
        y = np.concatenate([q, T])
        forces, _, _ = self.motion_forces(y, y, StepTimes.at_rest(time))
        lacking = multipliers @ self.constraint_jacobian(q, T) - prescribed
        return lacking - forces if forces.size else lacking

    def angle_terms(self, q: Array, T: Array) -> AngleTerms:
        """Phi_T, its gradient and its derivatives at one configuration."""
        _, y = self.at(q)
        c, s = y[self.c], y[self.s]
        return self._terms(T, T, c, c, s, s)

    def velocity_rows(self, q: Array) -> tuple[Array, Array]:
        """Gradients of the constraints, and of the joint coordinates where these are zero.

        Returns:
            Shapes (n_constraints, n_q) and (n_T, n_q).
        """
        G = self.functions.jacobian(q)
        return G[self.g], np.where(self.is_angle[:, None], G[self.s], G[self.c])

    def constraint_forces(self, q: Array, T: Array, multipliers: Array) -> tuple[Array, Array]:
        """Forces of constraints and joint coordinates in a configuration.

        Args:
            q: Coordinates, shape (n_q,).
            T: Joint coordinates, shape (n_T,).
            multipliers: (mu, nu, pi).

        Returns:
            Factors lambda, shape (n_rows,), and gradients G, shape (n_rows, n_q). The rows are the
            constraints with a multiplier, then the cosines (displacements) and the sines of all
            joint coordinates; -lambda_k G_k is the force of row k on q.
        """
        a, mu, nu = self.angle_terms(q, T), multipliers[self.g], multipliers[self.c]
        return np.concatenate([mu, a.g_c * nu, a.g_s * nu]), self.at(q)[0]

    def spring_energy(self, q: Array, T: Array) -> float:
        """Energy of all springs [J]."""
        if not self.forces:
            return 0.0
        y = np.concatenate([q, T])
        total = 0.0
        for force in self.forces:
            with name_errors(f"energy() of {describe(force)}"):
                total += float(force.energy(y[force.index]))
        return total

    def motion_forces(
        self, y0: Array, y1: Array, step: StepTimes
    ) -> tuple[Array, Array, Array | None]:
        """Forces in a step that depend on the motion, their sizes, and their derivatives by y1.

        Args:
            y0: Coordinates (q, T) at its start, shape (n_q + n_T,).
            y1: Coordinates at its end.
            step: Its length and middle.
        """
        if not self.forces:
            return NOTHING, NOTHING, None
        forces, sizes = np.zeros(y0.size), np.zeros(y0.size)
        slope = np.zeros((y0.size, y0.size))
        for e in self.forces:
            F, K = evaluate_force(e, y0[e.index], y1[e.index], step)
            forces[e.index] += F
            sizes[e.index] += np.abs(F)
            slope[np.ix_(e.index, e.index)] += K
        return forces, sizes, slope

    def motion_works(self, y0: Array, y1: Array, step: StepTimes) -> Array:
        """Work of each force in a step [J]: exactly force times increment."""
        works = []
        for e in self.forces:
            start, end = y0[e.index], y1[e.index]
            works.append(float(evaluate_force(e, start, end, step)[0] @ (end - start)))
        return np.array(works)

    def is_acceptable(self, q: Array, T: Array, turned: Array) -> bool:
        """Whether joint angles that turned so far lie on the right branch, and gaps are closed.

        Args:
            q: Coordinates, shape (n_q,).
            T: Joint coordinates, shape (n_T,).
            turned: Their increments in the last step.
        """
        (_, y), k = self.at(q), self.is_angle
        right = on_right_branch(turned[k], T[k], y[self.c][k], y[self.s][k])
        return right and float(np.abs(self.gaps(q)).max(initial=0.0)) <= REDUNDANT_GAP

    def gaps(self, q: Array) -> Array:
        """Values of the redundant constraints."""
        return self._redundant.value(q) if self._redundant.shape[0] else NOTHING

    def _jacobian_and_values(self, q: Array) -> tuple[Array, Array]:
        """Jacobian and values of all functions at a configuration."""
        G = self.functions.jacobian(q)
        return G, self.functions.value(q, G)
