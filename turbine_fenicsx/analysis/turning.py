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
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.statics import (
    at_rest,
    number_held,
    reach,
    solve_load_step,
)
from turbine_fenicsx.analysis.turning_blocks import TurningBlocks
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
"""Factor of the number of load steps towards a start that is only near an equilibrium; full bodies
have no such start, which kicks thin walls."""

NEAR = "reduced walls snap under these loads, and the start is near an equilibrium only, to {:g}"
"""Warning of it, with the part of the displacements."""

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
        StepFailure: if Newton's method does not converge. With reduced flexible bodies alone a
            state near the equilibrium is returned if there is one, with a warning in the log.

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
                if not loaded or blocks.system.has_large_bodies:
                    raise
                self._reach_loads(FINER * n, LOOSE)
                if blocks.system.comm.rank == 0:
                    log.warning(NEAR.format(LOOSE))
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
