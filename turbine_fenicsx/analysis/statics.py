"""Static equilibrium of a system.

At rest the equations of a step with dq = du = 0 are those of static equilibrium, and their tangent
with respect to the increments is half the stiffness, because discrete gradients are symmetric in
their two ends,

    K_step = | K/2  G^T |,      K_static = | K  G^T |.
             | G     0  |                  | G   0  |

So with the constraint residuals doubled, the linear solver of the step gives twice the Newton
increment of the displacements and the increment of the multipliers: Newton's method for
equilibrium needs no forms of its own. Inertia drops out because the step is taken to be very long.

What hangs in joints has its stiffness from the joint forces, so these must be known before the
first iteration. They are taken from a very short step, which is the start of the motion from rest.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.start import check_start
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.time_stepping.solver import StepFailure

log = logging.getLogger(__name__)

LONG_STEP = 1e8
"""Length of the step [s]; the masses weigh dt^2/2 times less than the stiffness."""

SHORT_STEP = 1e-6
"""Length of the step [s] that gives the first multipliers."""

SMALLEST_EXTENT = 1e-12
"""Displacements below this [m] count as none."""

ROUND_OFF = 1e-11
"""Increments that no longer decrease are round-off below this part of the size of the system."""

STAGNATION = 1e-8
"""... or below this part of the largest displacement."""


def equilibrium(
    system: MultibodySystem,
    times: Iterable[float] = (0.0,),
    state: State | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 30,
) -> State:
    """Static equilibrium under the loads at a time, reached through those at earlier times.

    Rigid bodies must not be free to move without stiffness, else the tangent is singular; weight
    makes one for what hangs. Loads are taken at the given times, so that a ramp with several of
    them is a sequence of load steps; prescribed motions are followed in the same way. Dampers and
    viscosity do not act. An equilibrium may be unstable, and there may be others.

    Args:
        system: The system.
        times: Times of the load steps [s].
        state: Where to start; the initial state if None. Not changed.
        tolerance: Newton's method ends when its increment is below this part of the largest
            displacement, or is round-off.
        max_iterations: Largest number of iterations per load step.

    Returns:
        The equilibrium under the loads at the last time, with zero velocities.

    Raises:
        TypeError, ValueError: for a start that is no state of this system.
        StepFailure: if Newton's method does not converge, or turns a joint by half a revolution
            or more in one load step.

    Note:
        Collective.
    """
    if state is not None:
        check_start(system, state)
    state = (system.initial_state() if state is None else state).copy()
    state.q_dot[:] = 0.0
    state.angle_rates[:] = 0.0
    for v in state.v:
        v.set(0.0)
    step = EnergyMomentumStep(system)
    solver = Elimination(step, "static_")
    try:
        with one_thread():
            for time in times:
                n = _newton(step, solver, state, time, tolerance, max_iterations)
                log.info("equilibrium at t = %g s after %d iterations", time, n)
    finally:
        solver.destroy()
    return state


def _newton(
    step: EnergyMomentumStep,
    solver: Elimination,
    state: State,
    time: float,
    tolerance: float,
    max_iterations: int,
) -> int:
    """Newton's method for one load step, changing the state; returns the iterations."""
    correction = step.new_nested_vector()
    start = state.angles.copy()
    if not np.any(state.multipliers):
        _first_multipliers(step, solver, state, time, correction)
    reach = _reach(step)
    sizes: list[float] = []
    last = np.inf
    for iteration in range(1, max_iterations + 1):
        step.begin(state, LONG_STEP, at=time)
        step.guess(extrapolate=False)
        step.residual(step.x, step.residual_vector)
        _scale_constraints(step, 2.0)
        solver.update(step.x)
        solver.solve(step.residual_vector, correction)
        size, extent = _move(step, state, correction)
        sizes.append(size / extent)
        if not np.isfinite(size):
            break
        stagnant = last <= size <= max(ROUND_OFF * reach, STAGNATION * extent)
        if size <= tolerance * extent or stagnant:
            _check_angles(step, state.angles - start, time)
            state.time = time
            return iteration
        last = size
    raise StepFailure(
        f"no equilibrium at t = {time:g} s: the increments of Newton's method relative to the "
        f"displacements are {', '.join(f'{s:.1e}' for s in sizes[-4:])} after {len(sizes)} "
        "iterations; more load steps may help"
    )


def _first_multipliers(
    step: EnergyMomentumStep, solver: Elimination, state: State, time: float, correction: PETSc.Vec
) -> None:
    """Set the multipliers to those with which the system starts to move from rest."""
    step.begin(state, SHORT_STEP, at=time)
    step.guess(extrapolate=False)
    step.residual(step.x, step.residual_vector)
    _scale_constraints(step, 0.0)
    solver.update(step.x)
    solver.solve(step.residual_vector, correction)
    _correct_multipliers(step, state, correction)


def _reach(step: EnergyMomentumStep) -> float:
    """Largest coordinate of any point of the system [m]. Collective."""
    system = step.system
    places = [np.max(np.abs(f.positions), initial=0.0) for f in system.flexible_blocks]
    places += [np.max(np.abs(b.position), initial=1.0) for b in system.rigid_bodies]
    return float(system.comm.allreduce(max(places, default=0.0), op=MPI.MAX))


def _check_angles(step: EnergyMomentumStep, turned: Array, time: float) -> None:
    """Raise a StepFailure if angles went astray in a load step or a redundant constraint opened."""
    block = step.system.rigid_block
    astray = bool(np.any(np.abs(turned[block.is_angle]) >= np.pi))
    if astray or not block.acceptable(step.rigid_step, np.zeros(block.size)):
        raise StepFailure(
            f"no equilibrium at t = {time:g} s: a joint turned by half a revolution or more in one "
            "load step, or a redundant constraint does not hold; more load steps may help"
        )


def _scale_constraints(step: EnergyMomentumStep, factor: float) -> None:
    """Scale the constraint residuals of the step."""
    _, R_c, R_r = step.split(step.residual_vector)
    for part in R_c:
        part.scale(factor)
    if R_r.array_r.size:
        for rigid in step.system.rigid_block.split(R_r.array)[2:]:
            rigid *= factor


def _move(step: EnergyMomentumStep, state: State, correction: PETSc.Vec) -> tuple[float, float]:
    """Apply a correction to the state.

    Returns:
        The largest increment of a displacement or director, and the largest displacement or
        director increment so far [m, -], equal on all ranks.
    """
    system = step.system
    du, _, dr = step.split(correction)
    size = extent = 0.0
    for u, increment in zip(state.u, du, strict=True):
        u.axpy(-0.5, increment)
        size = max(size, 0.5 * increment.norm(PETSc.NormType.NORM_INFINITY))
        extent = max(extent, u.norm(PETSc.NormType.NORM_INFINITY))
    _correct_multipliers(step, state, correction)
    dq, dT, *_ = system.rigid_block.split(step.on_all_ranks(dr))
    start = np.concatenate([np.zeros(0), *(b.coordinates for b in system.rigid_bodies)])
    state.q = state.q - 0.5 * dq
    state.angles = state.angles - 0.5 * dT
    size = max(size, 0.5 * float(np.max(np.abs(dq), initial=0.0)))
    extent = max(extent, float(np.max(np.abs(state.q - start), initial=0.0)), SMALLEST_EXTENT)
    return size, extent


def _correct_multipliers(step: EnergyMomentumStep, state: State, correction: PETSc.Vec) -> None:
    """Apply a correction to the multipliers of the state."""
    force = 2.0 / step.dt**2
    _, dmu, dr = step.split(correction)
    _, mu, r = step.split(step.x)
    for forces, multipliers, increment in zip(state.coupling, mu, dmu, strict=True):
        multipliers.copy(forces)
        forces.axpy(-1.0, increment)
        forces.scale(force)
    block = step.system.rigid_block
    _, _, *changes = block.split(step.on_all_ranks(dr))
    _, _, *rigid = block.split(step.on_all_ranks(r))
    state.multipliers = force * (np.concatenate(rigid) - np.concatenate(changes))
