"""Claims about telling rigid motions from others where round-off is large."""

from contextlib import contextmanager

import numpy as np
import pytest
from bricks import brick

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.complex_modes import complex_modes
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.quadratic_problem import QuadraticProblem
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel


@contextmanager
def thin_plate(comm, round_off=0.0, rate=0.0):
    """The problem of a free plate, with a part of the diagonal of K added to K, and D = rate M."""
    system = MultibodySystem(comm, [brick(comm, (10.0, 1.0, 0.02), (3, 1, 1))])
    state = system.initial_state()
    linear = LinearSystem(system, state)
    K, _ = blocks_of(linear.stiffness)
    diagonal = K.getDiagonal()
    diagonal.scale(1.0 + round_off)
    K.setDiagonal(diagonal)
    M, _ = blocks_of(linear.mass)
    D = M.copy()
    D.scale(rate)
    damping = linear.vectors.block_diagonal([D], np.zeros((0, 0)))
    try:
        yield QuadraticProblem(linear, linear.mass, damping if rate else None, linear.stiffness)
    finally:
        linear.destroy()
        for thing in (damping, D, diagonal, state):
            thing.destroy()


def modes_of(problem, count):
    """Whether each mode is rigid, and its eigenvalue."""
    found, _ = complex_modes(problem, count)
    for mode in found:
        mode.destroy()
    return [mode.is_rigid for mode in found], np.array([mode.eigenvalue for mode in found])


def test_rigid_motions_that_round_off_moves_far_are_told_from_others(comm):
    """Taken for the slowest vibrations they would draw the shift down to round-off."""
    with thin_plate(comm) as problem:
        _, exact = modes_of(problem, 9)
    with thin_plate(comm, round_off=2e-14) as problem:
        is_rigid, found = modes_of(problem, 9)
    assert is_rigid == [True] * 6 + [False] * 3
    assert found == pytest.approx(exact, rel=1e-4)


def test_motions_that_a_weak_damper_slows_down_are_not_rigid(comm):
    """They strain nothing, and are as slow as round-off could make rigid ones."""
    with thin_plate(comm, rate=0.04) as problem:
        is_rigid, found = modes_of(problem, 13)
    assert is_rigid == [True] * 6 + [False] * 7
    assert found[6:12] == pytest.approx([-0.04] * 6, rel=0.02)  # three digits are round-off
