"""Where a run starts: velocities that all parts can have together, and states that fit.

The rates v of the rigid bodies at given rates b of joint coordinates are those that are nearest to
the velocities v0 of the bodies,

    (v - v0).M (v - v0)/2 -> min,    G v = 0,    T v = b,

with the gradients G of the constraints and T of the joint coordinates. That is what impulses in the
joints make of v0: momenta of what is free stay as they are, and from rest the kinetic energy is
the least possible. Flexible bodies move as rigid ones with what they are coupled to: M counts their
mass, and G ties the parent bodies of each together.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from turbine_fenicsx.bodies.rigid_body import BodyFrame
from turbine_fenicsx.foundation.argument_checks import check_number
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import largest_of_ranks
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.redundancy import find_redundant_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.rigid import Rigid
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.initial_fields import initial_velocity
from turbine_fenicsx.system.prescribed_rows import find_rates
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

CONTRADICTION = 1e-9
"""Maximum error of a rate relative to the largest, against what joints and the other rates
allow."""

LARGEST_GAP = 1e-6
"""A state that opens a constraint further than this [m, -] does not belong to the system."""


def initial_motion(system: MultibodySystem, rates: Mapping[str, float]) -> State:
    """The initial state with given rates of joint coordinates.

    All bodies get the velocities nearest to those they were given that joints, couplings and rates
    allow (see above). Bodies on a turning joint turn with it. From rest, the motion with the least
    kinetic energy is taken where there is a choice.

    Args:
        system: The system.
        rates: Rates by the names of joint coordinates [rad/s, m/s].

    Returns:
        A state at t = 0 for the ``start`` of a `Simulation`.

    Raises:
        ModelError: if a joint coordinate is unknown, a rate is not a number, rates contradict each
            other or the joints, or the velocity field of a flexible body does not fit.

    Note:
        Collective.
    """
    wanted = _check_rates(system, rates)
    state = system.initial_state()
    q = state.q
    ties = QuadraticMap(_list_ties(system), q.size).jacobian(q)
    G, T = system.rigid_model.velocity_rows(q)
    A = np.concatenate([G, ties, T[[system.joint_coordinate_names.index(name) for name in wanted]]])
    follow = system.paths.rates(0.0)[: len(G)]
    b = np.concatenate([follow, np.zeros(len(ties)), list(wanted.values())])
    kept = np.setdiff1d(np.arange(len(A)), find_redundant_rows(A, 0))
    state.q_dot = _find_nearest(_mass_matrix(system), A[kept], b[kept], state.q_dot)
    state.joint_rates = T @ state.q_dot
    reached = dict(zip(system.joint_coordinate_names, state.joint_rates.tolist(), strict=True))
    for name, rate in wanted.items():
        if abs(reached[name] - rate) > CONTRADICTION * np.max(np.abs(b)):
            raise ModelError(
                f"the rate {rate:g} of {name!r} contradicts the joints and the other rates, which "
                f"make it {reached[name]:g}"
            )
    for block, coupling, u, v in zip(
        system.flexible_models, system.coupling_blocks, state.u, state.v, strict=True
    ):
        place = u.array_r.reshape(-1, 3)
        v.array[:] = initial_velocity(block, coupling, state.q_dot, place).ravel()
        gap = coupling.B_local @ state.q_dot[coupling.columns] - v.array_r[coupling.dofs]
        largest = [np.max(np.abs(x), initial=0.0) for x in (gap, v.array_r, state.q_dot)]
        error, *sizes = np.max(system.comm.allgather(largest), axis=0)
        if error > CONTRADICTION * max(sizes):
            raise ModelError(
                f"the velocity field of {block.body.name!r} contradicts the rates of the joints; "
                "leave it out, and the body moves with what carries it"
            )
    return state


def check_start(system: MultibodySystem, state: State) -> None:
    """Check that a state belongs to a system. Collective."""
    if not isinstance(state, State):
        raise TypeError(
            "a run starts from a State, such as the state of a snapshot, got a "
            f"{type(state).__name__}"
        )
    mine = system.initial_state()
    given, needed = _sizes(state), _sizes(mine)
    mine.destroy()
    if system.comm.allreduce(int(given != needed)):
        raise ModelError("the start state belongs to another system, its sizes are different")
    check_closed_state(system, replace(state, time=0.0))


def check_closed_state(system: MultibodySystem, state: State) -> None:
    """Check that a state fulfils the constraints, which the next step would close. Collective."""
    gaps = system.rigid_gaps(state)
    found = list(zip(np.abs(gaps).tolist(), system.constraint_owners, strict=True))
    coordinates = system.coordinates_of(state.q)
    for block, u in zip(system.coupling_blocks, state.u, strict=True):
        gap = np.abs(block.gap(coordinates, u)).reshape(-1, 3)
        for coupling, rows in zip(block.couplings, block.slices, strict=True):
            largest = float(gap[rows].max(initial=0.0))
            found.append((largest_of_ranks(system.comm, largest), coupling.name))
    wrong: dict[str, float] = {}
    for gap, owner in found:
        if not gap <= LARGEST_GAP:
            wrong[owner] = max(gap, wrong.get(owner, 0.0))
    if wrong:
        opened = ", ".join(f"{owner!r} by {gap:.2g}" for owner, gap in wrong.items())
        raise ModelError(
            f"the state at t = {state.time:g} s opens {opened}, which a step would snap shut: move "
            f"the bodies to where constraints hold (allowed: {LARGEST_GAP:g}), or is this the "
            "state of another system?"
        )


def check_motions(system: MultibodySystem, state: State | None) -> None:
    """Check that joint coordinates are where prescribed motions begin.

    Where they begin with another velocity, the log warns of it on one rank.

    Args:
        state: State at t = 0; None for the initial state, where all joint coordinates are zero.
    """
    model = system.rigid_model
    T = np.zeros(model.n_T) if state is None else state.joint_coordinates
    values, motions = model.S @ T, system.relation_values(0.0)
    for relation, value, p in zip(system.relations, values.tolist(), motions.tolist(), strict=True):
        if abs(p - value) > LARGEST_GAP * max(1.0, abs(p)):
            raise ModelError(
                f"{relation.name!r} begins at {p:g}, but the run starts at {value:g}: give it a "
                "start in which the joint stands there"
            )
    if not system.relations:
        return
    starts = [(b.coordinates, b.rates) for b in system.rigid_bodies]
    q, q_dot = np.hstack(starts) if state is None else (state.q, state.q_dot)
    _, rows = model.velocity_rows(q)
    rates = model.S @ rows @ q_dot
    motions = find_rates(system.relation_values, 0.0)
    for relation, rate, p in zip(system.relations, rates.tolist(), motions.tolist(), strict=True):
        if abs(p - rate) > LARGEST_GAP * max(1.0, abs(p)) and system.comm.rank == 0:
            log.warning(
                "%r begins with the rate %.6g, but the bodies start with %.6g; velocities will "
                "alternate from step to step: let the motion begin with the rate of the bodies, or "
                "let them start with its rate (initial_motion)",
                relation.name,
                p,
                rate,
            )


def _sizes(state: State) -> list[tuple[int, ...]]:
    """Sizes of all parts of a state, on this rank and in all."""
    arrays = (state.q, state.q_dot, state.joint_coordinates, state.joint_rates, state.multipliers)
    vectors = (state.u, state.v, state.coupling)
    counts = [(len(group),) for group in vectors]
    return [x.shape for x in arrays] + counts + [x.sizes for group in vectors for x in group]


def _check_rates(system: MultibodySystem, rates: Mapping[str, float]) -> dict[str, float]:
    """The rates as numbers; a ModelError if one is not the rate of a joint coordinate."""
    for name in rates:
        if name not in system.joint_coordinate_names:
            known = sorted(system.joint_coordinate_names)
            raise ModelError(f"no joint coordinate {name!r}; there are {known}")
    return {name: check_number(f"rate of {name!r}", rate) for name, rate in rates.items()}


def _list_ties(system: MultibodySystem) -> list[Quadratic]:
    """Constraints that keep the parent bodies of each flexible body together."""
    found = []
    frames = {body: BodyFrame(body, 4 * k) for k, body in enumerate(system.rigid_bodies)}
    for block in system.coupling_blocks:
        first, *others = dict.fromkeys(c.rigid for c in block.couplings) or [None]
        for body in others:
            a, b = (BodyFrame(None) if x is None else frames[x] for x in (first, body))
            found += Rigid("tie", first, body, (0.0, 0.0, 0.0)).constraints(a, b)
    return found


def _mass_matrix(system: MultibodySystem) -> Array:
    """Masses of the rigid bodies, and of the flexible ones as parts of a parent body."""
    M = np.diag(system.rigid_model.masses)
    for block, coupling in zip(system.flexible_models, system.coupling_blocks, strict=True):
        if coupling.carriers:
            grid = np.ix_(coupling.columns[:12], coupling.columns[:12])
            M[grid] += np.kron(_carried_mass(block, coupling), np.eye(3))
    return M


def _carried_mass(block: BodyModel, coupling: CouplingBlock) -> Array:
    """Mass of a flexible body that moves with its first parent body, shape (4, 4). Collective."""
    weights = coupling.carriers[0].weights_of(block.positions, block.is_point)
    field, momentum = block.new_vector(), block.new_vector()
    mass = np.zeros((4, 4))
    for k in range(4):
        field.array[0::3] = weights[:, k]
        block.momentum(field, momentum)
        mass[k] = momentum.array_r[0::3] @ weights
    for vector in (field, momentum):
        vector.destroy()
    return np.asarray(block.comm.allreduce(mass))


def _find_nearest(M: Array, A: Array, b: Array, v0: Array) -> Array:
    """The v with A v = b that is nearest to v0 in the norm of M; A has full rank."""
    Q, R = np.linalg.qr(A.T, mode="complete")
    rank = len(A)
    v = v0 + Q[:, :rank] @ np.linalg.solve(R[:rank].T, b - A @ v0)
    Z = Q[:, rank:]
    # least squares, as directors without mass have none to weigh
    return np.asarray(v - Z @ np.linalg.lstsq(Z.T @ M @ Z, Z.T @ (M @ (v - v0)), rcond=None)[0])
