"""Steady rotation of a system about the axis of a joint.

In the frame that turns at the speed Omega (`turning_frame`) the system is at rest in y0,

    grad V(y0) + M S^2 (y0 - a) + G(y0)^T lambda = 0,    Phi(y0) = 0,

with the angle of the joint held. Newton's method is that of static equilibrium with M S^2 in the
stiffness. Where the joint is carried by a body that moves, its axis z = (a, n) follows this body,
z' = Z y', so that with R_z, the derivatives of the forces with respect to the axis,

    (K + M S^2 + R_z Z) increment = residual,

which the factors of K + M S^2 solve too, as Z has six rows (Sherman, Morrison and Woodbury).
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.statics import (
    EquilibriumBlocks,
    at_rest,
    number_held,
    reach,
    solve_load_step,
)
from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

SPEED_STEPS = (1, 4, 16)
"""Numbers of steps, of equal squares of the speed, in which it is tried to reach the speed."""

LOAD_STEPS = (1, 5, 20)
"""Numbers of steps in which it is tried to reach the loads on sections, where there are some."""

ASTRAY = 0.1
"""Maximum increment after the third, relative to the displacements; beyond it, load steps are
taken. Wind that bends blades by a fifth of their length buckles the iterates of thin walls, and
Newton's method does not return from there."""

LOOSE = 1e-3
"""Tolerance of load steps before the last, which are only starts of the next. With 1e-2 a start of
IEA-22 with 36 by 30 cells came to another equilibrium, which differs by 4e-5."""

FINER = 4
"""Factor of the number of load steps towards a start that is only near an equilibrium."""

NEAR = (
    f"the start is near an equilibrium, to {LOOSE:g} of the displacements: reduced walls that snap "
    "under these loads have none that is found more accurately"
)
"""Warning of a start that full bodies could not have: it would kick thin walls."""

AZIMUTHS = (1.0, 2.5)
"""Further angles of the rotor at which a state must be in equilibrium to be steady [rad]."""

CHANGE = 1e-9
"""Maximum change of shape in a steady rotation, relative to the size; that of the speed in a turn
is some times as large."""

SMALL_TURN = 1e-3
"""Angle of the differences that velocities of a quasi-static change are made of [rad]."""


def turning_equilibrium(
    system: MultibodySystem,
    joint: str,
    speed: float,
    state: State | None = None,
    time: float = 0.0,
    periodic: bool = False,
    held: Iterable[str] = (),
    tolerance: float = 1e-10,
    max_iterations: int = 30,
    add_change: bool = True,
) -> State:
    """The state in which a system turns steadily about the axis of a joint.

    Everything on the second side of the joint turns, what is on the first is at rest. The axis is
    where the first partner is in this state. The energy-momentum scheme keeps such a state exactly,
    for any step. Forces that depend on velocities, except dampers in the joint, act as if at rest.

    Args:
        system: The system.
        joint: Name of a joint whose coordinates have one angle, such as a revolute joint.
        speed: Omega, the rate of this angle [rad/s]; zero holds the joint.
        state: Where to start, and at which angle; the initial state if None. Not changed.
        time: Time of all forces and prescribed motions [s].
        periodic: Whether forces may change as the system turns, like weight across the axis. No
            state is steady then: the shape is that of the present angle, and the velocities are
            those of the rotation and of the change of this shape with the angle.
        held: Names of other joint coordinates that stay as they are, by whatever force that takes.
        tolerance: As in `equilibrium`.
        max_iterations: As in `equilibrium`.
        add_change: Whether a periodic state also has the velocities of its change of shape.

    Returns:
        The state, with the velocities of the rotation and the joint forces of Omega.

    Raises:
        TypeError, ModelError: if the start is not a state of this system, the joint cannot turn, a
            joint coordinate is unknown, or the rotation is not steady and not `periodic`.
        StepFailure: if Newton's method does not converge. Where all flexible bodies are reduced, a
            state near the equilibrium is returned then, with a warning in the log, if there is one.

    Note:
        Collective.
    """
    state = at_rest(system, state)
    frame = turning_frame(system, joint, speed, state)
    names = [system.joint_coordinate_names[frame.coordinate], *held]
    blocks = TurningBlocks(frame, state, number_held(system, names))
    solver = Elimination(blocks, "turning_", blocks.is_symmetric)
    turning = _Turning(blocks, solver, time, tolerance, max_iterations)
    try:
        with one_thread():
            turning.reach_speed()
            blocks.frame.set_velocities(blocks.state)
            if speed:
                _add_what_changes(turning, periodic, add_change)
    finally:
        solver.destroy()
        blocks.destroy()
    return blocks.state


def _add_what_changes(turning: _Turning, periodic: bool, add_change: bool) -> None:
    """Add the velocities of what changes as a system turns, or refuse it."""
    frame, state = turning.blocks.frame, turning.blocks.state
    torque = turning.torque()
    inertia = 2.0 * frame.system.balance(state).kinetic / frame.speed**2
    if not periodic and abs(torque) > CHANGE * inertia * frame.speed**2:
        raise ModelError(
            f"the rotation about {frame.joint!r} at {frame.speed:g} rad/s is not steady: a torque "
            f"of {torque:.3g} N m about its axis changes the speed"
        )
    change = turning.find_change() if add_change or not periodic else 0.0
    if not periodic and change > CHANGE:
        raise ModelError(
            f"the rotation about {frame.joint!r} at {frame.speed:g} rad/s is not steady: the shape "
            f"changes by {change:.1e} of the size of the system as it turns; leave out what does "
            "not turn with it, such as gravity, or allow periodic changes"
        )
    if change > CHANGE:
        turning.add_change()
    log.info(
        "turning about %r at %g rad/s; a torque of %.3g N m changes the speed by %.3g rad/s^2",
        frame.joint,
        frame.speed,
        torque,
        torque / inertia,
    )


class TurningBlocks(EquilibriumBlocks):
    """Residual and tangent of equilibrium in a turning frame.

    Args:
        frame: The frame; its axis follows the state.
        state: The state, whose displacements, coordinates and multipliers are the unknowns.
        held: Numbers of the joint coordinates that stay as they are.

    Attributes:
        frame: The frame of the last residual.
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
        """Assemble the residual at the state, with the axis that belongs to it."""
        frame = self.frame
        self.frame = turning_frame(self.system, frame.joint, frame.speed, self.state)
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


@dataclass(frozen=True)
class _Turning:
    """A turning equilibrium being found: its equations and how to solve them."""

    blocks: TurningBlocks
    solver: Elimination
    time: float
    tolerance: float
    max_iterations: int

    def solve(self, time: float, is_close: bool = False) -> None:
        """Newton's method for the frame of the blocks, changing their state."""
        accuracy = self.tolerance, self.max_iterations
        solve_load_step(self.blocks, self.solver, time, *accuracy, is_close)

    def reach_speed(self) -> None:
        """Find the equilibrium, at lower speeds or loads first if it is too far away."""
        blocks, frame = self.blocks, self.blocks.frame
        start = blocks.state.copy()
        loaded = any(m.section_loads for m in blocks.system.flexible_models)
        numbers = LOAD_STEPS if loaded else SPEED_STEPS
        for n in numbers:
            try:
                if loaded:
                    self._reach_loads(n, self.tolerance)
                else:
                    self._reach_speed(n, frame)
                break
            except StepFailure:
                blocks.state.destroy()
                blocks.state, blocks.frame = start.copy(), frame
                if n < numbers[-1]:
                    continue
                if not (loaded and all(m.is_small for m in blocks.system.flexible_models)):
                    raise
                self._reach_loads(FINER * n, LOOSE)
                if blocks.system.comm.rank == 0:
                    log.warning(NEAR)
        start.destroy()

    def _reach_speed(self, n: int, frame: TurningFrame) -> None:
        """Find the equilibrium at n speeds."""
        for k in range(1, n + 1):
            self.blocks.frame = replace(frame, speed=frame.speed * np.sqrt(k / n))
            self.solve(self.time)

    def _reach_loads(self, n: int, tolerance: float) -> None:
        """Find the equilibrium at n parts of the loads on sections, before that without them."""
        blocks, before = self.blocks, None
        astray = np.inf if n == LOAD_STEPS[-1] else ASTRAY
        for k in range(1 if n == 1 else 0, n + 1):
            blocks.part = k / n
            now = blocks.state.copy()
            if before is not None:
                if k > 1:
                    blocks.state.extrapolate_from(before)
                before.destroy()
            accuracy = tolerance if k == n else LOOSE, self.max_iterations
            solve_load_step(blocks, self.solver, self.time, *accuracy, astray=astray)
            before = now
        now.destroy()

    @contextmanager
    def turned(self, angle: float) -> Iterator[float]:
        """The blocks at a copy of their state that is turned by an angle; yields its time [s]."""
        blocks, frame = self.blocks, self.blocks.frame
        state, other = blocks.state, blocks.state.copy()
        frame.turn(other, angle)
        blocks.state = other
        yield self.time + (angle / frame.speed if frame.is_driven else 0.0)
        blocks.state, blocks.frame = state, frame
        other.destroy()

    def torque(self) -> float:
        """Torque about the joint that nothing balances, that of dampers included [N m]."""
        frame = self.blocks.frame
        model = frame.system.rigid_model
        held = -self.blocks.rigid_residual()[model.n_q + frame.coordinate]
        start, end = (self._turned_coordinates(x) for x in (-0.5 * SMALL_TURN, 0.5 * SMALL_TURN))
        step = StepTimes(SMALL_TURN / frame.speed, self.time, self.time)
        works = model.motion_works(start, end, step)
        dissipates = [f.kind == "dissipative" for f in frame.system.motion_forces]
        return float(held + works[np.array(dissipates, dtype=bool)].sum() / SMALL_TURN)

    def _turned_coordinates(self, angle: float) -> Array:
        """(q, Theta) of the state turned by an angle."""
        with self.turned(angle):
            state = self.blocks.state
            return np.concatenate([state.q, state.joint_coordinates])

    def find_change(self) -> float:
        """Change of shape at other azimuths, to first order, in parts of the size of the system.

        Returns:
            The largest up to the first azimuth where it is more than `CHANGE`.

        Note:
            Collective.
        """
        blocks, size, change = self.blocks, reach(self.blocks.system), 0.0
        for angle in AZIMUTHS:
            with self.turned(angle) as blocks.time:
                blocks.residual()
                blocks.solve(self.solver)
                du, _, dr = blocks.split(blocks.correction)
                dq = blocks.on_all_ranks(dr)[: blocks.system.rigid_model.n_q]
                parts = [part.norm(PETSc.NormType.NORM_INFINITY) for part in du]
                parts += [change * size, np.max(np.abs(dq), initial=0.0)]
                change = float(np.max(parts)) / size
            if change > CHANGE:
                break
        blocks.time = self.time
        return change

    def add_change(self) -> None:
        """Add the velocities of the quasi-static change with the azimuth to those of the state."""
        state, speed = self.blocks.state, self.blocks.frame.speed
        for sign in (1.0, -1.0):
            with self.turned(sign * SMALL_TURN) as time:
                self.solve(time, is_close=True)
                other = self.blocks.state
                self.blocks.frame.turn(other, -sign * SMALL_TURN)
                rate = 0.5 * sign * speed / SMALL_TURN
                state.q_dot = state.q_dot + rate * other.q
                state.joint_rates = state.joint_rates + rate * other.joint_coordinates
                for v, u in zip(state.v, other.u, strict=True):
                    v.axpy(rate, u)
