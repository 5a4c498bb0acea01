"""Motions of a turning system as columns: its slowest modes, its rotation, and driven ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from petsc4py import PETSc

import numpy as np
from scipy.linalg import eigh

from turbine_fenicsx.analysis.bordered_solver import BorderedSolver, FlatVectors
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.quadratic_problem import QuadraticProblem
from turbine_fenicsx.analysis.small_problem import find_allowed
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.foundation.parallel import on_rank0, sum_over_ranks
from turbine_fenicsx.foundation.types import Array

DEPENDENT = 1e-20
"""Part of the modal mass of the rotation below which it is a sum of the slowest modes."""


def find_slow_motions(
    frame: TurningFrame,
    problem: QuadraticProblem,
    number: int,
    driven: Mapping[str, float] | None = None,
) -> Array:
    """X, this rank's rows of the slowest modes of the structure and of its rotation. Collective.

    Args:
        frame: What turns.
        problem: Its matrices.
        number: Of modes.
        driven: Joint coordinates with prescribed motions, and what 1 of a common motion makes of
            each; it is one more column, normal to the others in the mass matrix.
    """
    linear, comm = problem.linear, problem.linear.system.comm
    solver = linear.solver(linear.mass, "modes_")
    solver.factorise()
    Q = find_allowed(linear, solver.solve)
    p = np.zeros((len(Q), 0))
    if driven is not None:
        p = _find_prescribed(linear, solver, driven)
    solver.destroy()
    M, K = (project(A, linear.vectors, Q) for A in (linear.mass, problem.stiffness))
    K_p = sum_over_ranks(comm, Q.T @ multiply(problem.stiffness, linear.vectors, p))
    rotation = sum_over_ranks(comm, Q.T @ find_rotation(frame, linear))
    X, rest = on_rank0(comm, lambda: _choose(M, K, rotation, K_p, number))
    p = p + Q @ rest
    masses = sum_over_ranks(comm, (Q @ X).T @ multiply(linear.mass, linear.vectors, p))
    return np.column_stack([Q @ X, p - Q @ (X @ masses)])


def _choose(M: Array, K: Array, rotation: Array, K_p: Array, number: int) -> tuple[Array, Array]:
    """Slow modes with the rotation, and what prescribed motions need of the fast modes.

    These follow without inertia, and so prescribed motions strain the structure hardly.
    """
    squares, modes = eigh(0.5 * (K + K.T), M)
    slow, fast = modes[:, :number], modes[:, number:]
    rest = -fast @ ((fast.T @ K_p) / squares[number:, None])
    # the rotation of bent blades is nearly a sum of slow modes, and would be lost in round-off
    other = rotation / np.sqrt(rotation @ M @ rotation)
    for _ in range(3):
        other = other - slow @ (slow.T @ (M @ other))
        mass = other @ M @ other
        if mass <= DEPENDENT:
            return slow, rest
        other = other / np.sqrt(mass)
    return np.column_stack([slow, other]), rest


def _find_prescribed(
    linear: LinearSystem, solver: BorderedSolver, driven: Mapping[str, float]
) -> Array:
    """The motion with the least kinetic energy of prescribed coordinates, this rank's column."""
    names, vectors = linear.system.joint_coordinate_names, linear.vectors
    moved = [solver.move(names.index(name), change) for name, change in driven.items()]
    b, y = vectors.new_vector(), vectors.new_vector()
    solver.solve(b, y, np.sum(moved, axis=0))
    found: Array = y.array_r[:, None].copy()
    b.destroy()
    y.destroy()
    return found


def find_rotation(frame: TurningFrame, linear: LinearSystem) -> Array:
    """This rank's part of the rotation of all that turns, at 1 rad/s."""
    moving = linear.state.copy()
    replace(frame, speed=1.0).set_velocities(moving)
    parts = [v.array_r.copy() for v in moving.v]
    if linear.system.comm.rank == 0:
        parts += [moving.q_dot, moving.joint_rates]
    moving.destroy()
    return np.concatenate([np.zeros(0), *parts])


def project(matrix: PETSc.Mat, vectors: FlatVectors, X: Array) -> Array:
    """X^T A X. Collective."""
    return sum_over_ranks(vectors.system.comm, X.T @ multiply(matrix, vectors, X))


def multiply(matrix: PETSc.Mat, vectors: FlatVectors, X: Array) -> Array:
    """A X, this rank's rows. Collective."""
    x, y = vectors.new_vector(), vectors.new_vector()
    image = np.empty_like(X)
    for j in range(X.shape[1]):
        x.array[:] = X[:, j]
        matrix.mult(x, y)
        image[:, j] = y.array_r
    x.destroy()
    y.destroy()
    return image
