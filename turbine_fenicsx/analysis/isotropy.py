"""Whether a rotor is isotropic, so that its equations in multiblade coordinates are constant.

C must commute with the matrices of all that turns. Constraints and forces between the rotor, turned
by psi, and its support must be the same for all psi: with T = R(psi) exp(-psi J), the motion in
space of multiblade coordinates,

    G(psi) T(psi) z = 0,    T^T A(psi) T = A(0) for z with G(0) z = 0,

A being the stiffness and damping of springs and dampers. Joint coordinates follow the bodies, and
are taken out first.
"""

from __future__ import annotations

from collections.abc import Iterator

from petsc4py import PETSc

import numpy as np
from scipy.linalg import null_space

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.cyclic_shift import CyclicShift, joint_rates
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State

EQUAL_TOLERANCE = 1e-6
"""Maximum change of matrices by a shift of equal blades, relative to their size."""

AZIMUTH = 1.0
"""Another azimuth at which constraints and forces are compared [rad]."""


def check_isotropic(frame: TurningFrame, linear: LinearSystem, shift: CyclicShift) -> None:
    """Check that what turns is a rotor of equal blades, and is carried alike at every azimuth.

    Raises:
        ModelError: if it is not, with what differs; on all ranks.

    Note:
        Collective.
    """
    system, words = linear.system, ["mass", "stiffness"]
    matrices = [linear.mass, linear.stiffness]
    if linear.damping is not None:
        words, matrices = [*words, "damping"], [*matrices, linear.damping]
    for word, matrix in zip(words, matrices, strict=True):
        for k, (A, C) in enumerate(zip(blocks_of(matrix)[:-1], shift.bodies, strict=True)):
            if C is not None:
                _refuse(word, system.flexible_bodies[k].name, _change(A, C), shift)
    for k, C in enumerate(shift.bodies):
        if C is not None:
            change = _change_of_contact(linear, k, C, shift)
            _refuse("the surface in contact", system.flexible_bodies[k].name, change, shift)
    for word, change in system.comm.bcast(list(_changes_of_rigid(frame, linear, shift))):
        _refuse(word, "the rigid bodies", change, shift)


def moving_carrier(frame: TurningFrame, linear: LinearSystem) -> bool:
    """Whether anything moves that does not turn."""
    if not all(frame.flexible_turns):
        return True
    if all(frame.rigid_turns):
        return False
    turning = np.repeat(frame.rigid_turns, 12)
    rows = _constraints(linear, linear.state)
    alone = rows[~np.any(rows[:, turning] != 0.0, axis=1)][:, ~turning]
    return bool(np.linalg.matrix_rank(alone) < np.count_nonzero(~turning))


def _refuse(word: str, what: str, change: float, shift: CyclicShift) -> None:
    """Raise a ModelError if something changes."""
    if change > EQUAL_TOLERANCE:
        raise ModelError(
            f"multiblade coordinates need a rotor of {shift.blades} equal blades on an axis about "
            f"which it is isotropic: turned by 1/{shift.blades} of a revolution, {word} of {what} "
            f"changes by {change:.1e} of its size, and {EQUAL_TOLERANCE:g} is allowed"
        )


def _change(A: PETSc.Mat, C: PETSc.Mat) -> float:
    """Size of (A C - C A) x over that of A C x for a random x."""
    x, y, z = (A.createVecRight() for _ in range(3))
    x.setRandom()
    A.mult(x, y)
    C.mult(y, z)
    C.mult(x, y)
    A.mult(y, x)
    size = x.norm()
    x.axpy(-1.0, z)
    change = x.norm() / size if size else 0.0
    for vector in (x, y, z):
        vector.destroy()
    return float(change)


def _change_of_contact(linear: LinearSystem, body: int, C: PETSc.Mat, shift: CyclicShift) -> float:
    """How much the contact of a body with rigid bodies changes when it is shifted."""
    coupling, model = linear.system.coupling_blocks[body], linear.system.flexible_models[body]
    q = np.sin(np.arange(1.0, len(shift.rigid) + 1.0))
    x, y = model.new_vector(), model.new_vector()
    x.array[coupling.dofs] = coupling.B_local @ q[coupling.columns]
    C.mult(x, y)
    size = y.norm()
    y.array[coupling.dofs] -= coupling.B_local @ (shift.rigid @ q)[coupling.columns]
    change = y.norm() / size if size else 0.0
    x.destroy()
    y.destroy()
    return float(change)


def _changes_of_rigid(
    frame: TurningFrame, linear: LinearSystem, shift: CyclicShift
) -> Iterator[tuple[str, float]]:
    """Relative difference allowed in the rigid part. Collective."""
    model, state = linear.system.rigid_model, linear.state
    C, M = shift.rigid, model.mass_matrix
    yield "mass", _relative(M @ C - C @ M, M)
    J = shift.rigid_generator
    turned = state.copy()
    frame.turn(turned, AZIMUTH)
    turned.destroy()  # of its arrays nothing else is needed
    T = _turn(frame) @ (np.eye(len(J)) + J @ J * (1.0 - np.cos(AZIMUTH)) - J * np.sin(AZIMUTH))
    rows = _constraints(linear, state)
    N = null_space(rows) if len(rows) else np.eye(len(J))
    yield "what the joints allow", _relative(_constraints(linear, turned) @ T @ N, rows)
    for word, before, after in zip(
        ("the springs", "the dampers"),
        _forces(linear, state),
        _forces(linear, turned),
        strict=True,
    ):
        yield word, _relative(N.T @ (T.T @ after @ T - before) @ N, before)


def _turn(frame: TurningFrame) -> Array:
    """The rotation of the coordinates of all that turns, shape (n_q, n_q)."""
    R = np.kron(np.eye(4), rotation_about(frame.axis, AZIMUTH))
    turns = np.diag(frame.rigid_turns.astype(float))
    return np.asarray(np.kron(turns, R) + np.kron(np.eye(len(turns)) - turns, np.eye(12)))


def _constraints(linear: LinearSystem, state: State) -> Array:
    """Gradients of all constraints with respect to q alone, shape (constraints, n_q)."""
    model = linear.system.rigid_model
    G = model.constraint_jacobian(state.q, state.joint_coordinates)
    rates = joint_rates(model, state)
    return np.concatenate([G[: model.n_constraints, : model.n_q], model.S @ rates])


def _forces(linear: LinearSystem, state: State) -> tuple[Array, Array]:
    """Stiffness and damping of forces that follow the motion, with respect to q alone."""
    model, y = linear.system.rigid_model, np.concatenate([state.q, state.joint_coordinates])
    _, _, slope = model.motion_forces(y, y, StepTimes.at_rest(state.time))
    K = np.zeros((y.size, y.size)) if slope is None else -2.0 * slope
    D = model.damping(state.q, state.joint_coordinates, state.time)
    rates = joint_rates(model, state)
    return _reduced(K, rates), _reduced(D, rates)


def _reduced(A: Array, rates: Array) -> Array:
    """A matrix of (q, T) as one of q alone, the joint coordinates following."""
    E = np.concatenate([np.eye(rates.shape[1]), rates])
    return np.asarray(E.T @ A @ E)


def _relative(change: Array, whole: Array) -> float:
    """Norm of a change over that of what changes."""
    size = float(np.linalg.norm(whole))
    return float(np.linalg.norm(change)) / size if size else 0.0
