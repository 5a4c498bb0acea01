"""Modes of a turning system in the air: eigenvalues with the states of wake, stall and lift.

Motions are sums z = X a of the m slowest modes of the structure, of unit modal mass, and of its
rotation about the axis. With the matrices of `turning_modes` and the terms of `air_terms`,

    | a   |'   |       0             1         0          | | a    |
    | a'  |  = | X^T F_z - K    X^T F_v - D    X^T F_zeta | | a'   |,
    | zeta|    |     g_z X         g_v X    g_zeta + W J  | | zeta |

whose eigenvalues are all found. There are hundreds, most of them of the air. Those of the structure
are told apart by the share of a and a' in them, the sum of the products of left and right
eigenvectors, which is 1 for an eigenvector without states and 0 for one of states alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
from scipy.linalg import eig, eigh

from turbine_fenicsx.analysis.air_terms import AirTerms, find_air_terms
from turbine_fenicsx.analysis.bordered_solver import FlatVectors
from turbine_fenicsx.analysis.complex_modes import make_mode
from turbine_fenicsx.analysis.cyclic_shift import CyclicShift, cyclic_shift
from turbine_fenicsx.analysis.isotropy import check_isotropic
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.quadratic_problem import QuadraticProblem
from turbine_fenicsx.analysis.slepc import Pair
from turbine_fenicsx.analysis.small_problem import find_allowed
from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.analysis.turning_modes import turning_problem
from turbine_fenicsx.analysis.whirl import WhirlMeter
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

MOTIONS = 100
"""Number of modes of the structure whose sums motions are."""

DEPENDENT = 1e-20
"""Part of the modal mass of the rotation below which it is a sum of the slowest modes."""

STRUCTURAL = 0.4
"""Least share of motions in a mode of the structure; the rest are motions of the air."""


@dataclass(frozen=True)
class AirModel:
    """How the air follows motions.

    Args:
        frozen: Models of the air whose states stay as they are, such as ``"wake"``.
        instant: Models whose states are in balance at each moment.
    """

    frozen: tuple[str, ...] = ()
    instant: tuple[str, ...] = ()


def air_modes(
    system: MultibodySystem,
    joint: str,
    speed: float,
    state: State,
    count: int = 12,
    blades: int | None = 3,
    air: AirModel = AirModel(),
    motions: int = MOTIONS,
) -> Modes:
    """Modes of a system that turns steadily in the air.

    Args:
        system: The system; its loads on sections must come from sources that act on bodies that
            turn, and should know their states (`StateLoad`).
        joint: As in `turning_modes`.
        speed: As in `turning_modes`.
        state: The state of steady rotation, see `turning_equilibrium`. Not changed.
        count: Number of modes.
        blades: As in `turning_modes`.
        air: How the air follows.
        motions: Number of modes of the structure whose sums motions are.

    Returns:
        The modes of the structure with the smallest eigenvalues, by rising frequency; those
        without any frequency come first.

    Raises:
        InputError: if slepc4py is not installed.
        ModelError: if nothing in the system has loads on sections, or multiblade coordinates do
            not suit the rotor.

    Note:
        Collective.
    """
    frame, linear = turning_frame(system, joint, speed, state), LinearSystem(system, state)
    shift = meter = problem = None
    try:
        if blades is not None:
            shift = cyclic_shift(frame, state, blades)
            check_isotropic(frame, linear, shift)
            meter = WhirlMeter(linear, shift, speed)
        problem = turning_problem(frame, linear, shift)
        X = _find_motions(frame, problem, motions)
        terms = _find_terms(frame, linear.vectors, state, X, shift, air)
        pairs = _find_pairs(problem, X, terms, count)
        modes = [make_mode(problem, pair, False, meter) for pair in pairs]
        for pair in pairs:
            pair.destroy()
    finally:
        for thing in (problem, meter, shift, linear):
            if thing is not None:
                thing.destroy()
    modes.sort(key=lambda mode: (mode.eigenvalue.imag, abs(mode.eigenvalue)))
    return Modes(state, tuple(modes), joint, speed, blades)


def _find_motions(frame: TurningFrame, problem: QuadraticProblem, number: int) -> Array:
    """X, this rank's rows of the slowest modes of the structure and of its rotation."""
    linear, comm = problem.linear, problem.linear.system.comm
    solver = linear.solver(linear.mass, "modes_")
    solver.factorise()
    Q = find_allowed(linear, solver.solve)
    solver.destroy()
    M, K = (_project(A, linear.vectors, Q) for A in (linear.mass, problem.stiffness))
    rotation = _find_rotation(frame, linear)

    def find() -> Array:
        _, slowest = eigh(0.5 * (K + K.T), M, subset_by_index=(0, min(number, len(M)) - 1))
        # the rotation of bent blades is nearly a sum of these, and would be lost in round-off
        rest = along / np.sqrt(along @ M @ along)
        for _ in range(3):
            rest = rest - slowest @ (slowest.T @ (M @ rest))
            mass = rest @ M @ rest
            if mass <= DEPENDENT:
                return np.asarray(slowest)
            rest = rest / np.sqrt(mass)
        return np.column_stack([slowest, rest])

    along = sum_over_ranks(comm, Q.T @ rotation)
    return np.asarray(Q @ on_rank0(comm, find))


def _find_rotation(frame: TurningFrame, linear: LinearSystem) -> Array:
    """This rank's part of the rotation of all that turns."""
    moving = linear.state.copy()
    frame.set_velocities(moving)
    parts = [v.array_r.copy() for v in moving.v]
    if linear.system.comm.rank == 0:
        parts += [moving.q_dot, moving.joint_rates]
    moving.destroy()
    return np.concatenate([np.zeros(0), *parts])


def _project(matrix: PETSc.Mat, vectors: FlatVectors, X: Array) -> Array:
    """X^T A X. Collective."""
    x, y = vectors.new_vector(), vectors.new_vector()
    image = np.empty_like(X)
    for j in range(X.shape[1]):
        x.array[:] = X[:, j]
        matrix.mult(x, y)
        image[:, j] = y.array_r
    x.destroy()
    y.destroy()
    return sum_over_ranks(vectors.system.comm, X.T @ image)


def _find_terms(
    frame: TurningFrame,
    vectors: FlatVectors,
    state: State,
    X: Array,
    shift: CyclicShift | None,
    air: AirModel,
) -> list[AirTerms]:
    """Terms of all loads on sections."""
    system = frame.system
    if system.rigid_section_loads or not any(m.section_loads for m in system.flexible_models):
        raise ModelError(
            "modes in the air need loads on sections of flexible bodies, and none of rigid ones"
        )
    rows = vectors.split_rows(X)
    return [
        find_air_terms(frame, body, loads, state, rows[body], shift)
        .freeze(air.frozen)
        .follow(air.instant)
        for body, model in enumerate(system.flexible_models)
        for loads in model.section_loads
    ]


def _find_pairs(
    problem: QuadraticProblem, X: Array, terms: list[AirTerms], count: int
) -> list[Pair]:
    """Eigenvalues of the structure with their motions, by rising size."""
    vectors = problem.linear.vectors
    D, K = (
        np.zeros((X.shape[1],) * 2) if A is None else _project(A, vectors, X)
        for A in (problem.damping, problem.stiffness)
    )
    A = _assemble(D, K, terms)
    values, motions = on_rank0(vectors.system.comm, lambda: _solve(A, X.shape[1], count))
    pairs = []
    for s, a in zip(values, motions.T, strict=True):
        parts = vectors.new_vector(), vectors.new_vector()
        for part, values_of in zip(parts, (a.real, a.imag), strict=True):
            part.array[:] = X @ values_of
        pairs.append(Pair(complex(s), parts))
    return pairs


def _assemble(D: Array, K: Array, terms: list[AirTerms]) -> Array:
    """The matrix of first order."""
    m, sizes = len(K), [len(t.models) for t in terms]
    A = np.zeros((2 * m + sum(sizes),) * 2)
    a, rate = slice(0, m), slice(m, 2 * m)
    A[a, rate], A[rate, a], A[rate, rate] = np.eye(m), -K, -D
    for t, end in zip(terms, 2 * m + np.cumsum(sizes), strict=True):
        states = slice(end - len(t.models), end)
        A[rate, a] += t.by_motion
        A[rate, rate] += t.by_rate
        A[rate, states] = t.by_states
        A[states, a], A[states, rate] = t.rates_by_motion, t.rates_by_rate
        A[states, states] = t.rates_by_states + t.whirl
    return A


def _solve(A: Array, m: int, count: int) -> tuple[Array, Array]:
    """Eigenvalues of the structure by rising size, one of each pair, and their a, shape (m, k)."""
    values, left, right = eig(A, left=True, right=True)
    products = left.conj() * right
    of_motions = products[: 2 * m].sum(axis=0) / products.sum(axis=0)
    structural = (np.abs(of_motions) >= STRUCTURAL) & (values.imag >= 0.0)
    chosen = np.flatnonzero(structural)
    chosen = chosen[np.argsort(np.abs(values[chosen]))][:count]
    return values[chosen], right[:m, chosen]
