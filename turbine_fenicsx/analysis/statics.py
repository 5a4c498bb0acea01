"""Static equilibrium of a system.

With the forces that displacements u, coordinates y and multipliers lack for equilibrium, Newton's
method solves

    | K_uu  C^T  0   |             | R_u + C^T mu_c |
    | C     0    B   | increment = | Phi_c          |
    | 0     B^T  K_r |             | R_r + B^T mu_c |

with the stiffness K of the bodies, by the linear solver of the time steps. Hanging bodies get their
stiffness from the joint forces, so these must be known before the first iteration. They are those
with which the system starts to move from rest.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import border
from turbine_fenicsx.foundation.errors import ModelError, NoEquilibrium
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.nested_blocks import NestedBlocks
from turbine_fenicsx.system.start import check_start
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

EARLY = 1e-12
"""Square of the time [s^2] for which the first multipliers are those of the motion from rest: they
follow from the masses, and from the stiffness where there is no mass."""

UNHELD = 4e-16
"""Stiffness of rigid bodies that nothing holds, over their masses [1/s^2]: without forces they stay
where they are, and with forces they go so far that there is no equilibrium."""

SMALLEST_EXTENT = 1e-12
"""Displacements below this [m] count as none."""

ROUND_OFF = 1e-11
"""Round-off of increments that no longer decrease, relative to the size of the system."""

SMALLER = 0.15
"""Maximum increment after which a tangent may be kept, relative to the last one; for the first,
relative to the displacements."""

MIN_LINEAR_RATIO = 0.6
"""... or, where new tangents no longer speed up convergence, relative to the last increment. Loads
that are not in the tangent, such as those of the air, leave linear convergence, which the present
tangent has as well."""

MAX_KEPT_INCREMENT = 1e-4
"""Part of the displacements below which that is looked for: farther away it may be chance."""

MIN_RATIO_QUOTIENT = 0.3
"""Minimum quotient of the last two ratios of increments in linear convergence; with Newton's method
the last ratio is the square of the one before, or less."""

GROWS = 2.0
"""Ratio to the last increment above which an increment grows."""

LAST = 1e-3
"""Part of the tolerance for an increment by a tangent that was kept: the error that it leaves is a
part of it, while that of a new tangent leaves its square."""

STAGNATION = 1e-8
"""... or relative to the largest displacement."""


def equilibrium(
    system: MultibodySystem,
    times: Iterable[float] = (0.0,),
    state: State | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 30,
    held: Iterable[str] = (),
) -> State:
    """Static equilibrium under the forces at a time, reached through those at earlier times.

    Rigid bodies must not be free to move without stiffness, else the tangent is singular; weight
    makes one for what hangs, and what turns freely can be held. Loads are taken at the given times,
    so that a ramp with several of them is a sequence of load steps; prescribed motions are followed
    in the same way. Dampers and viscosity do not act. An equilibrium may be unstable, and there may
    be others.

    Args:
        system: The system.
        times: Times of the load steps [s].
        state: Where to start; the initial state if None. Not changed.
        tolerance: Newton's method ends when its increment, relative to the largest displacement, is
            below this, or is round-off.
        max_iterations: Largest number of iterations per load step.
        held: Names of joint coordinates that stay as they are, by whatever force that takes.

    Returns:
        The equilibrium under the forces at the last time, with zero velocities.

    Raises:
        TypeError, ModelError: if the start is not a state of this system, or a joint coordinate is
            unknown.
        StepFailure: if Newton's method does not converge, or turns a joint by half a revolution
            or more in one load step.

    Note:
        Collective.
    """
    state = at_rest(system, state)
    blocks = EquilibriumBlocks(system, state, number_held(system, held))
    solver = Elimination(blocks, "static_", blocks.is_symmetric)
    try:
        with one_thread():
            for time in times:
                n = solve_load_step(blocks, solver, time, tolerance, max_iterations)
                log.info("equilibrium at t = %g s after %d iterations", time, n)
    finally:
        solver.destroy()
        blocks.destroy()
    return state


def at_rest(system: MultibodySystem, state: State | None) -> State:
    """A copy of a state, the initial one if None, with zero velocities. Collective."""
    if state is not None:
        check_start(system, state)
    state = (system.initial_state() if state is None else state).copy()
    state.q_dot[:] = 0.0
    state.joint_rates[:] = 0.0
    for v in state.v:
        v.set(0.0)
    return state


def number_held(system: MultibodySystem, names: Iterable[str]) -> list[int]:
    """Numbers of joint coordinates that must be held; a prescribed motion holds some already."""
    known = system.joint_coordinate_names
    for name in names:
        if name not in known:
            raise ModelError(f"no joint coordinate {name!r}; there are {sorted(known)}")
    driven = [tuple(relation.factors) for relation in system.relations]
    return [known.index(name) for name in dict.fromkeys(names) if (name,) not in driven]


class EquilibriumBlocks(NestedBlocks):
    """Residual and tangent of static equilibrium at a state.

    Args:
        state: The state, whose displacements, coordinates and multipliers are the unknowns.
        held: Numbers of the joint coordinates that stay as they are.

    Attributes:
        time: Time of all forces and motions [s].
        mass: Factor of the mass matrix that is added to the stiffness [1/s^2].
    """

    def __init__(self, system: MultibodySystem, state: State, held: Sequence[int] = ()) -> None:
        super().__init__(system, tuple(m.new_stiffness() for m in system.flexible_models))
        self.state, self.time, self.mass = state, 0.0, 0.0
        self._held = system.rigid_model.n_q + np.array(held, dtype=int)
        for m, K, u in zip(system.flexible_models, self.tangents, state.u, strict=True):
            m.assemble_stiffness(u, 0.0, K)  # linear solvers need the sparsity when they are made
        self.residual_vector, self.correction = self.new_nested_vector(), self.new_nested_vector()

    @property
    def is_symmetric(self) -> bool:
        """Whether the tangents of the flexible bodies are symmetric."""
        return all(m.is_conservative for m in self.system.flexible_models)

    def residual(self) -> None:
        """Assemble the residual at the state."""
        system, state = self.system, self.state
        R_u, R_c, R_r = self.split(self.residual_vector)
        R = self.rigid_residual()  # on all ranks, which thus all meet its errors
        if self.n_r:
            R_r.array[:] = R
            R_r.array[self._held] = 0.0
        coordinates = system.coordinates_of(state.q)
        for i, (m, c) in enumerate(
            zip(system.flexible_models, system.coupling_blocks, strict=True)
        ):
            C_T, B_T = self.transposed[i]
            m.static_forces(state.u[i], system.gravity, self.time, R_u[i])
            C_T.multAdd(state.coupling[i], R_u[i], R_u[i])
            B_T.multAdd(state.coupling[i], R_r, R_r)
            R_c[i].array[:] = c.gap(coordinates, state.u[i])

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble the tangent at the state; x, which linear solvers hand over, is not used."""
        state = self.state
        models = self.system.flexible_models
        for m, K, u in zip(models, self.tangents, state.u, strict=True):
            m.assemble_stiffness(u, self.time, K)
            if self.mass:
                m.add_mass(self.mass * np.eye(3), K)
        K = self._rigid_tangent()  # on all ranks, too
        K[self._held, :] = K[:, self._held] = 0.0
        K[self._held, self._held] = 1.0
        self.set_rigid_tangent(K[: self.n_r, : self.n_r])

    def solve(self, solver: Elimination, update: bool = True) -> None:
        """Solve for the correction by the tangent at the state, or by the last one."""
        if update:
            solver.update(self.residual_vector)
        solver.solve(self.residual_vector, self.correction)

    def destroy(self) -> None:
        """Free the matrices and vectors."""
        for thing in (*self.tangents, self.residual_vector, self.correction, self.tangent_matrix):
            thing.destroy()

    def rigid_residual(self) -> Array:
        """R_r without the coupling forces, and as if no joint coordinate was held."""
        system, state, model = self.system, self.state, self.system.rigid_model
        load_q, load_T = (
            forces.sum(axis=0) for forces in system.evaluate_prescribed_forces(self.time)
        )
        prescribed = np.concatenate([load_q + system.gravity_force(system.gravity), load_T])
        lacking = model.static_forces(
            state.q, state.joint_coordinates, state.multipliers, self.time, prescribed
        )
        n = model.n_constraints + model.n_T
        return np.concatenate(
            [
                lacking,
                model.constraint_values(state.q, state.joint_coordinates)[:n]
                - system.paths.values(self.time),
                model.S @ state.joint_coordinates - system.relation_values(self.time),
            ]
        )

    def _rigid_tangent(self) -> Array:
        """K_r, shape (n_r, n_r)."""
        state, model = self.state, self.system.rigid_model
        K = model.stiffness(state.q, state.joint_coordinates, state.multipliers, self.time)
        K[: model.n_q, : model.n_q] += (self.mass + UNHELD) * model.mass_matrix
        return border(K, model.constraint_jacobian(state.q, state.joint_coordinates))


def solve_load_step(
    blocks: EquilibriumBlocks,
    solver: Elimination,
    time: float,
    tolerance: float,
    max_iterations: int,
    is_close: bool = False,
    astray: float = np.inf,
) -> int:
    """Newton's method for one load step, changing the state of the blocks.

    Args:
        time: Time of all forces and motions [s].
        is_close: Whether the equilibrium is close, so that the tangent is kept as long as
            increments become smaller fast. Else it is kept only where convergence is linear.
        astray: Part of the displacements above which no increment after the third may grow.

    Returns:
        The number of iterations.
    """
    state = blocks.state
    start = state.joint_coordinates.copy()
    blocks.time = time
    if state.multipliers.size and not np.any(state.multipliers):
        _set_first_multipliers(blocks, solver)
    extent_of_system = reach(blocks.system)
    sizes: list[float] = []
    update, last = True, np.inf
    for iteration in range(1, max_iterations + 1):
        blocks.residual()
        blocks.solve(solver, update)
        size, extent = _move(blocks)
        sizes.append(size / extent)
        leaves = iteration > 3 and size > max(astray * extent, GROWS * last)
        if not np.isfinite(size) or leaves:
            break
        stagnant = last <= size <= max(ROUND_OFF * extent_of_system, STAGNATION * extent)
        accurate = size <= (1.0 if update else LAST) * tolerance * extent
        if accurate or stagnant:
            _check_angles(blocks, start)
            state.time = time
            return iteration
        far = size > (SMALLER if is_close else MIN_LINEAR_RATIO) * (
            extent if iteration == 1 else last
        )
        keeps = is_close or not update or _is_linear(sizes)
        update, last = far or not keeps, size
    raise NoEquilibrium(
        f"no equilibrium at t = {time:g} s: the increments of Newton's method relative to the "
        f"displacements are {', '.join(f'{s:.1e}' for s in sizes[-4:])} after {len(sizes)} "
        "iterations",
        f"more load steps may help{_advise(blocks.system)}",
    )


def _is_linear(sizes: Sequence[float]) -> bool:
    """Whether the last increments, relative to the displacements, fall by equal factors."""
    if len(sizes) < 3 or sizes[-1] > MAX_KEPT_INCREMENT:
        return False
    before, now = sizes[-2] / sizes[-3], sizes[-1] / sizes[-2]
    return MIN_RATIO_QUOTIENT * before <= now <= MIN_LINEAR_RATIO


def _advise(system: MultibodySystem) -> str:
    """How joint coordinates that nothing drives may be kept from drifting."""
    driven = {name for r in system.relations if r.motion is not None for name in r.factors}
    free = [name for name in system.joint_coordinate_names if name not in driven]
    return f", or to hold what turns freely, of {', '.join(free)}, by held=[...]" if free else ""


def _set_first_multipliers(blocks: EquilibriumBlocks, solver: Elimination) -> None:
    """Set the multipliers to those with which the system starts to move from rest."""
    blocks.residual()
    _, R_c, R_r = blocks.split(blocks.residual_vector)
    for part in R_c:
        part.set(0.0)
    if blocks.n_r:
        model = blocks.system.rigid_model
        R_r.array[model.n_q + model.n_T :] = 0.0
    blocks.mass = 2.0 / EARLY
    solver.update(blocks.residual_vector)
    blocks.mass = 0.0
    solver.solve(blocks.residual_vector, blocks.correction)
    _correct_multipliers(blocks)


def reach(system: MultibodySystem) -> float:
    """Largest coordinate of any point of the system [m]. Collective."""
    places = [np.max(np.abs(m.positions), initial=0.0) for m in system.flexible_models]
    places += [np.max(np.abs(b.position), initial=1.0) for b in system.rigid_bodies]
    return float(system.comm.allreduce(max(places, default=0.0), op=MPI.MAX))


def _check_angles(blocks: EquilibriumBlocks, start: Array) -> None:
    """Raise a StepFailure if angles went astray in a load step or a redundant constraint opened."""
    model, state = blocks.system.rigid_model, blocks.state
    astray = bool(np.any(np.abs(state.joint_coordinates - start)[model.is_angle] >= np.pi))
    if astray or not model.is_acceptable(state.q, state.joint_coordinates, np.zeros(start.size)):
        raise NoEquilibrium(
            f"no equilibrium at t = {blocks.time:g} s: a joint turned by half a revolution or more "
            "in one load step, or a redundant constraint does not hold",
            "more load steps may help",
        )


def _move(blocks: EquilibriumBlocks) -> tuple[float, float]:
    """Apply the correction to the state.

    Returns:
        The largest increment of a displacement or director, and the largest displacement or
        director increment so far [m, -], equal on all ranks.
    """
    system, state = blocks.system, blocks.state
    du, _, dr = blocks.split(blocks.correction)
    moved, far = [0.0], [SMALLEST_EXTENT]
    for u, increment in zip(state.u, du, strict=True):
        u.axpy(-1.0, increment)
        moved.append(increment.norm(PETSc.NormType.NORM_INFINITY))
        far.append(u.norm(PETSc.NormType.NORM_INFINITY))
    _correct_multipliers(blocks)
    dq, dT, *_ = system.rigid_model.split(blocks.on_all_ranks(dr))
    start = np.concatenate([np.zeros(0), *(b.coordinates for b in system.rigid_bodies)])
    state.q = state.q - dq
    state.joint_coordinates = state.joint_coordinates - dT
    moved.append(np.max(np.abs(dq), initial=0.0))
    far.append(np.max(np.abs(state.q - start), initial=0.0))
    return float(np.max(moved)), float(np.max(far))  # not a number if one of them is none


def _correct_multipliers(blocks: EquilibriumBlocks) -> None:
    """Apply the correction to the multipliers of the state."""
    _, dmu, dr = blocks.split(blocks.correction)
    for forces, increment in zip(blocks.state.coupling, dmu, strict=True):
        forces.axpy(-1.0, increment)
    _, _, *changes = blocks.system.rigid_model.split(blocks.on_all_ranks(dr))
    blocks.state.multipliers = blocks.state.multipliers - np.concatenate(changes)
