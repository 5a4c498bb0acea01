"""Modes of small vibrations about an equilibrium, without damping."""

from __future__ import annotations

from cmath import sqrt

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import FlatVectors
from turbine_fenicsx.analysis.equal_modes import choose_basis, choose_phase, group_neighbours
from turbine_fenicsx.analysis.equilibrium_check import check_equilibrium, imbalance
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.mode import Mode, Modes
from turbine_fenicsx.analysis.slepc import Pair, import_slepc
from turbine_fenicsx.analysis.squared_frequencies import SquaredFrequencies
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.foundation.argument_checks import check_positive
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

EQUAL_TOLERANCE = 1e-8
"""Squares of frequencies that differ by less than this part are one."""


def modes(
    system: MultibodySystem,
    state: State | None = None,
    count: int = 12,
    shift: float | None = None,
    tolerance: float = 1e-8,
) -> Modes:
    """Modes of small vibrations about an equilibrium, those whose squared frequency is nearest 0.

    Dampers and viscosity do not act. Options of PETSc with the prefix ``modes_`` change the
    iteration; ``-modes_eps_monitor`` shows it. Modes of one frequency are a basis that does not
    depend on the number of ranks.

    Args:
        system: The system.
        state: The equilibrium, with the multipliers of its constraint forces, as
            `turbine_fenicsx.equilibrium` returns it; None finds it. Velocities count as zero.
        count: Number of modes.
        shift: Square of a frequency, about so large as the lowest that matters, by which the
            iteration is shifted [rad^2/s^2]. None chooses it.
        tolerance: Of the iteration, relative.

    Returns:
        The modes by rising frequency; those that grow come first, without any. Pressures and
        follower forces can also make vibrations grow. `Modes.state` is the state given or found.

    Raises:
        InputError: if slepc4py is not installed.
        TypeError: if the state is not a `State`.
        ModelError: for a state that is not in equilibrium, or more modes than there are.
        StepFailure: if no equilibrium is found, the iteration does not converge, or a mode does
            not fulfil the equations.

    Note:
        Collective.
    """
    import_slepc()
    if not isinstance(count, int | np.integer) or count < 1:
        raise ModelError(f"the number of modes must be a positive whole number, got {count!r}")
    if shift is not None:
        check_positive("shift", shift)
    check_positive("tolerance", tolerance)
    if state is not None:
        check_equilibrium(system, state)
    with one_thread():
        rest = find_rest(system) if state is None else state
        problem = LinearSystem(system, rest)
        try:
            return Modes(rest, modes_of(problem, count, shift, tolerance))
        finally:
            problem.destroy()


def modes_of(
    linear: LinearSystem, count: int, shift: float | None = None, tolerance: float = 1e-8
) -> tuple[Mode, ...]:
    """The modes of a linear system, to whose stiffness the shift is added. Collective."""
    SLEPc, free = import_slepc(), linear.degrees_of_freedom
    if count > free:
        raise ModelError(f"{count} modes, but the system has {free} degrees of freedom")
    with one_thread():
        problem = SquaredFrequencies(SLEPc, linear, shift)
        try:
            pairs = problem.find(count, tolerance)
        finally:
            problem.destroy()
        pairs = _put_in_order(linear.vectors, pairs, problem.symmetric)
    found = tuple(_mode(linear.vectors, pair) for pair in pairs[:count])
    for pair in pairs:
        pair.destroy()
    return found


def find_rest(system: MultibodySystem) -> State:
    """The initial state at rest if it is an equilibrium, else the one that is found. Collective."""
    state = system.initial_state()
    state.q_dot[:] = 0.0
    for v in state.v:
        v.set(0.0)
    if imbalance(system, state).is_equilibrium:
        return state
    state.destroy()
    return equilibrium(system)


def _eigenvalue(pair: Pair) -> complex:
    """Root s of s^2 = -w^2 that vibrates, or else that grows [rad/s]."""
    if pair.is_rigid:
        return 0j
    root = sqrt(-pair.eigenvalue)
    return root if root.imag >= 0.0 else -root


def _put_in_order(flat: FlatVectors, pairs: list[Pair], symmetric: bool) -> list[Pair]:
    """Pairs by rising frequency, those that grow first, with vectors chosen in one way."""

    def rank(pair: Pair) -> tuple[float, float]:
        s = _eigenvalue(pair)
        return s.imag, -s.real

    def are_equal(a: Pair, b: Pair) -> bool:
        near = abs(b.eigenvalue - a.eigenvalue) <= EQUAL_TOLERANCE * abs(b.eigenvalue)
        return symmetric and (near or (a.is_rigid and b.is_rigid))

    groups = list(group_neighbours(sorted(pairs, key=rank), are_equal))
    for group in groups:
        if len(group[0].parts) == 1:
            choose_basis(flat, [pair.parts[0] for pair in group])
        else:
            choose_phase(flat, *group[0].parts)
    return [pair for group in groups for pair in group]


def _mode(flat: FlatVectors, pair: Pair) -> Mode:
    """A pair as the motion of all parts."""
    a, *b = map(flat.motion, pair.parts)
    return Mode(_eigenvalue(pair), a, b[0] if b else None, pair.is_rigid)
