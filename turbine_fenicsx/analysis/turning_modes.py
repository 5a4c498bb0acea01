"""Modes of systems that turn steadily.

There are two frames. One turns with all that moves: S = omega x and J = 0. The other has multiblade
coordinates z of a rotor on a fixed support, y = exp(-psi J) z with the azimuth psi = Omega t and J
of `cyclic_shift`:

    M z'' + (D + 2 M S') z' + (K + M S'^2 - Omega D J) z + G^T l = 0,    S' = S - Omega J.

J commutes with M, K, D and S, and S' vanishes for the motions of a rigid hub as seen from outside.
So the constraints between the rotor and its support are those at psi = 0.
"""

from __future__ import annotations

from collections.abc import Iterable

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.complex_modes import check_count, complex_modes
from turbine_fenicsx.analysis.cyclic_shift import CyclicShift, cyclic_shift, joint_rates
from turbine_fenicsx.analysis.isotropy import check_isotropic, moving_carrier
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.quadratic_problem import DIFFERENT, QuadraticProblem
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_frame import TurningFrame, turning_frame
from turbine_fenicsx.analysis.whirl import WhirlMeter
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

RESISTANCE = 1e-8
"""Round-off of the forces of a rigid rotation, relative to damping times velocity."""


def turning_problem(
    frame: TurningFrame, linear: LinearSystem, shift: CyclicShift | None = None
) -> QuadraticProblem:
    """The quadratic problem of a steadily turning system. Collective.

    Args:
        frame: What turns, about which axis and how fast.
        linear: The system about its steady state.
        shift: The cyclic shift for multiblade coordinates; None for those that turn.

    Returns:
        The problem; its damping and stiffness are new matrices.
    """
    masses, stiffnesses = blocks_of(linear.mass), blocks_of(linear.stiffness)
    dampings = [None] * len(masses) if linear.damping is None else blocks_of(linear.damping)
    damping, stiffness = [], []
    for k, turns in enumerate(frame.flexible_turns):
        J = None if shift is None else shift.body_generators[k]
        D, K = _body_terms(frame, k, turns, masses[k], dampings[k], stiffnesses[k], J)
        damping.append(D)
        stiffness.append(K)
    D_r, K_r = np.zeros((0, 0)), np.zeros((0, 0))
    if linear.system.comm.rank == 0:
        D_r, K_r = _rigid_terms(frame, linear, dampings[-1], stiffnesses[-1], shift)
    vectors = linear.vectors
    return QuadraticProblem(
        linear,
        linear.mass,
        vectors.block_diagonal(damping, D_r),
        vectors.block_diagonal(stiffness, K_r),
    )


def check_rotation_is_free(frame: TurningFrame, linear: LinearSystem) -> None:
    """Check that no force resists the rotation itself, except dampers in its joint. Collective."""
    if linear.damping is None or not frame.speed:
        return
    *flexible, rigid = blocks_of(linear.damping)
    for k, (D, turns) in enumerate(zip(flexible, frame.flexible_turns, strict=True)):
        if turns:
            velocity, force = D.createVecs()
            velocity.array[:] = (frame.body_arms(k, linear.state.u[k]) @ frame.spin.T).ravel()
            D.mult(velocity, force)
            part = force.norm() / (D.norm() * velocity.norm() or 1.0)
            velocity.destroy()
            force.destroy()
            _refuse_resistance(part, frame.system.flexible_bodies[k].name, frame.joint)
    moving = linear.state.copy()
    frame.set_velocities(moving)
    velocities = np.concatenate([moving.q_dot, np.zeros_like(moving.joint_rates)])
    moving.destroy()
    part = 0.0
    if linear.system.comm.rank == 0:
        D_r = rigid.getDenseArray()
        size = np.linalg.norm(D_r) * np.linalg.norm(velocities)
        part = float(np.linalg.norm(D_r @ velocities) / (size or 1.0))
    _refuse_resistance(linear.system.comm.bcast(part), "the rigid bodies", frame.joint)


def _refuse_resistance(part: float, what: str, joint: str) -> None:
    """Raise a ModelError for forces above a part of those that a rotation could cause."""
    if part > RESISTANCE:
        raise ModelError(
            f"a force on {what} depends on the velocity of the steady rotation about {joint!r}, "
            "of which its modes know nothing: leave it out, or take a damper of the joint"
        )


def _body_terms(
    frame: TurningFrame,
    body: int,
    turns: bool,
    M: PETSc.Mat,
    D: PETSc.Mat | None,
    K: PETSc.Mat,
    J: PETSc.Mat | None,
) -> tuple[PETSc.Mat, PETSc.Mat]:
    """New matrices of the rates and of the coordinates of a flexible body."""
    speed, stiffness = frame.speed, K.copy()
    MS, MSS = frame.body_matrix(body, 1), frame.body_matrix(body, 2)
    if turns:
        stiffness.axpy(1.0, MSS, DIFFERENT)
    gyroscopic = MS.copy()
    gyroscopic.scale(2.0)
    if J is not None:
        MJ, MSJ = M.matMult(J), MS.matMult(J)
        MJJ = MJ.matMult(J)
        gyroscopic.axpy(-2.0 * speed, MJ, DIFFERENT)
        stiffness.axpy(-2.0 * speed, MSJ, DIFFERENT)
        stiffness.axpy(speed * speed, MJJ, DIFFERENT)
        for matrix in (MJ, MSJ, MJJ):
            matrix.destroy()
    if D is not None:
        gyroscopic.axpy(1.0, D, DIFFERENT)
        if J is not None:
            DJ = D.matMult(J)
            stiffness.axpy(-speed, DJ, DIFFERENT)
            DJ.destroy()
    for matrix in (MS, MSS):
        matrix.destroy()
    return gyroscopic, stiffness


def _rigid_terms(
    frame: TurningFrame,
    linear: LinearSystem,
    damping: PETSc.Mat | None,
    stiffness: PETSc.Mat,
    shift: CyclicShift | None,
) -> tuple[Array, Array]:
    """The same matrices of the rigid part (q | T), on rank 0."""
    MS = frame.rigid_matrix(1)
    D, K = 2.0 * MS, stiffness.getDenseArray() + frame.rigid_matrix(2)
    viscous = np.zeros_like(D) if damping is None else damping.getDenseArray()
    if shift is not None:
        speed, J = frame.speed, rigid_generator(linear, shift)
        MJ = frame.rigid_matrix(0) @ J
        D -= 2.0 * speed * MJ
        K += -2.0 * speed * MS @ J + speed**2 * MJ @ J - speed * viscous @ J
    return D + viscous, K


def rigid_generator(linear: LinearSystem, shift: CyclicShift) -> Array:
    """J of the rigid part (q | T): joint coordinates follow the bodies."""
    model, state = linear.system.rigid_model, linear.state
    J = np.zeros((linear.vectors.n_y,) * 2)
    J[: model.n_q, : model.n_q] = shift.rigid_generator
    J[model.n_q :, : model.n_q] = joint_rates(model, state) @ shift.rigid_generator
    return J


def turning_modes(
    system: MultibodySystem,
    joint: str,
    speed: float,
    count: int = 12,
    blades: int | None = None,
    state: State | None = None,
    held: Iterable[str] = (),
) -> Modes:
    """Modes of a system that turns steadily about the axis of a joint.

    In the turning frame, frequencies are those that somebody sees who turns too. Where what does
    not turn can move, as a flexible tower does, the equations are constant in multiblade
    coordinates only: frequencies are then those seen from the ground, and `Mode.whirl` says which
    way round a mode goes.

    Args:
        system: The system.
        joint: Name of a joint whose coordinates have one angle, such as a revolute joint.
        speed: Rate of this angle [rad/s].
        count: Number of modes.
        blades: Number of equal blades, three or more, for multiblade coordinates. All blades must
            belong to one flexible body, or be rigid. None for the turning frame.
        state: Where `turning_equilibrium` starts, and at which angle; the initial state if None.
        held: Names of joint coordinates that stay as they are while the equilibrium is found, such
            as a yaw that nothing else holds; in the modes they are free.

    Returns:
        The modes with the smallest eigenvalues, by rising frequency; `Modes.state` is the
        equilibrium, which the caller frees.

    Raises:
        InputError: if slepc4py is not installed. ModelError: if the joint does not turn, the speed
        is not a number, or there are fewer degrees of freedom than modes. Also if the rotation is
        not steady, forces depend on its speed, or multiblade coordinates do not suit the rotor.
        StepFailure: if no equilibrium is found, or the iteration does not converge.

    Note:
        Collective.
    """
    found, _ = turning_modes_near(system, joint, speed, count, blades, state, held)
    return found


def turning_modes_near(
    system: MultibodySystem,
    joint: str,
    speed: float,
    count: int,
    blades: int | None,
    state: State | None,
    held: Iterable[str] = (),
    shift: float | None = None,
    more: int = 0,
) -> tuple[Modes, float]:
    """`turning_modes` with some more modes, if there are any, and the lowest frequency.

    Args:
        shift: First guess of the lowest frequency [rad/s].
        more: Number of additional modes.
    """
    import_slepc()
    if blades is not None:
        _check_rotor(system, joint, speed, blades, state)
    found = turning_equilibrium(system, joint, speed, state, held=held)
    frame = turning_frame(system, joint, speed, found)
    linear = LinearSystem(system, found)
    rotor = problem = meter = None
    try:
        check_count(linear, count)
        if blades is not None:
            rotor = cyclic_shift(frame, found, blades)
            meter = WhirlMeter(linear, rotor, speed)
            check_isotropic(frame, linear, rotor)
        elif speed and moving_carrier(frame, linear):
            raise ModelError(
                f"what carries joint {joint!r} can move, so that the equations in the turning "
                "frame change with the azimuth: give the number of equal blades for multiblade "
                "coordinates, or hold what does not turn"
            )
        check_rotation_is_free(frame, linear)
        problem = turning_problem(frame, linear, rotor)
        with one_thread():
            number = min(count + more, linear.degrees_of_freedom)
            modes, lowest = complex_modes(problem, number, shift, meter)
    except BaseException:
        found.destroy()
        raise
    finally:
        if problem is not None:
            problem.destroy()
        for thing in (meter, rotor, linear):
            if thing is not None:
                thing.destroy()
    return Modes(found, modes, joint, speed, blades), lowest


def _check_rotor(
    system: MultibodySystem, joint: str, speed: float, blades: int, state: State | None
) -> None:
    """Check a rotor before its equilibrium, which may not exist for unequal blades. Collective."""
    start = system.initial_state() if state is None else state
    frame, linear = turning_frame(system, joint, speed, start), LinearSystem(system, start)
    rotor = None
    try:
        rotor = cyclic_shift(frame, start, blades)
        check_isotropic(frame, linear, rotor)
    finally:
        if rotor is not None:
            rotor.destroy()
        linear.destroy()
        if state is None:
            start.destroy()
