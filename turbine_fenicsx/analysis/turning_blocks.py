"""Residual and tangent of steady rotation; the equations are those of `turning`."""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.statics import EquilibriumBlocks
from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.state import State


class TurningBlocks(EquilibriumBlocks):
    """Residual and tangent of equilibrium in a turning frame.

    Args:
        frame: The frame; its axis follows the state.
        state: The state, whose displacements, coordinates and multipliers are the unknowns.
        held: Numbers of the joint coordinates that stay as they are.

    Attributes:
        part: Part of the loads on sections that acts.
    """

    def __init__(self, frame: TurningFrame, state: State, held: Sequence[int]) -> None:
        super().__init__(frame.system, state, held)
        self.frame, self.part = frame, 1.0
        joint = next(j for j in self.system.joints if j.name == frame.joint)
        carrier = joint.bodies[0]
        self._carrier = None if carrier is None else self.system.first_coordinate[carrier]
        self._forces = [m.new_vector() for m in self.system.flexible_models]
        n = 0 if carrier is None else 6
        self._columns = [self.new_nested_vector() for _ in range(n)]

    def residual(self) -> None:
        """Assemble the residual at the state, with the axis that belongs to it.

        Raises:
            StepFailure: if the iteration has gone so far astray that the joint has no axis.
        """
        frame = self.frame
        try:
            self.frame = turning_frame(self.system, frame.joint, frame.speed, self.state)
        except ModelError as error:
            raise StepFailure(f"the turning equilibrium was not found: {error}") from None
        super().residual()
        R_u, _, _ = self.split(self.residual_vector)
        for body, (R, force) in enumerate(zip(R_u, self._forces, strict=True)):
            u = self.state.u[body]
            self.frame.body_centrifugal_force(body, u, force)
            R.axpy(1.0, force)
            if self.part < 1.0:
                still = np.zeros_like(u.array_r)
                for loads in self.system.flexible_models[body].section_loads:
                    loads.add_forces(u.array_r, still, self.time, 1.0 - self.part, R.array)

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble the tangent at the state and at a constant axis."""
        super().tangent(x)
        for body, (K, turns) in enumerate(
            zip(self.tangents, self.frame.flexible_turns, strict=True)
        ):
            if turns:
                self.system.flexible_models[body].add_mass(self.frame.spin @ self.frame.spin, K)

    def solve(self, solver: Elimination, update: bool = True) -> None:
        """Solve for the correction as in equilibrium, the axis being free to move."""
        super().solve(solver, update)
        if self._carrier is None:
            return
        Z = self._axis_gradient(self._carrier)
        W = np.zeros((6, 6))
        for k, column in enumerate(self._columns):
            self._axis_derivative(k, self.residual_vector)
            solver.solve(self.residual_vector, column)
            W[:, k] = Z @ self._motion_of_carrier(column)
        z = np.linalg.solve(np.eye(6) + W, Z @ self._motion_of_carrier(self.correction))
        for part, column in zip(z, self._columns, strict=True):
            self.correction.axpy(-part, column)

    def rigid_residual(self) -> Array:
        """R_r without the coupling forces, and as if no joint coordinate was held."""
        R = super().rigid_residual()
        R[: self.system.rigid_model.n_q] += self.frame.rigid_centrifugal_force(self.state.q)
        return R

    def destroy(self) -> None:
        """Free the matrices and vectors."""
        super().destroy()
        for vector in (*self._forces, *self._columns):
            vector.destroy()

    def _rigid_tangent(self) -> Array:
        """K_r, shape (n_r, n_r)."""
        K = super()._rigid_tangent()
        M = self.frame.rigid_matrix(2)
        K[: len(M), : len(M)] += M
        return K

    def _axis_gradient(self, first: int) -> Array:
        """Z, how the axis (a, n) moves with the coordinates of its parent body, shape (6, 12)."""
        phi, *directors = self.state.q[first : first + 12].reshape(4, 3)
        of_point = [1.0, *(directors @ (self.frame.point - phi))]
        of_axis = [0.0, *(np.array(directors) @ self.frame.axis)]
        return np.kron(np.array([of_point, of_axis]), np.eye(3))

    def _axis_derivative(self, k: int, out: PETSc.Vec) -> None:
        """Column k of R_z, the derivative of M S^2 (x - a) with respect to (a, n), into out."""
        frame = self.frame
        n, e, S2 = frame.axis, np.eye(3)[k % 3], frame.spin @ frame.spin
        # S^2 = Omega^2 (n n^T - 1)
        slope = frame.speed**2 * (np.outer(e, n) + np.outer(n, e))
        u, _, r = self.split(out)
        out.set(0.0)
        for body, part in enumerate(u):
            if frame.flexible_turns[body]:
                arms = frame.body_arms(body, self.state.u[body])
                field = arms @ slope.T if k >= 3 else np.broadcast_to(-S2 @ e, arms.shape)
                force = self._forces[body]
                force.array[:] = field.ravel()
                self.system.flexible_models[body].momentum(force, part)
        if self.n_r:
            arms = frame.rigid_arms(self.state.q)
            accelerations = arms @ slope.T if k >= 3 else np.zeros_like(arms)
            if k < 3:
                accelerations[:, 0] = -S2 @ e
            model = self.system.rigid_model
            r.array[: model.n_q] = model.masses * frame.of_turning(accelerations)

    def _motion_of_carrier(self, x: PETSc.Vec) -> Array:
        """The part of a nested vector that moves the parent body of the axis, shape (12,)."""
        assert self._carrier is not None
        return self.on_all_ranks(self.split(x)[2])[self._carrier : self._carrier + 12]
