"""Modes of systems that turn steadily."""

from __future__ import annotations

from collections.abc import Iterable

from turbine_fenicsx.analysis.complex_modes import check_count, complex_modes
from turbine_fenicsx.analysis.cyclic_shift import cyclic_shift
from turbine_fenicsx.analysis.isotropy import check_isotropic, moving_carrier
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.analysis.turning_problem import check_rotation_is_free, turning_problem
from turbine_fenicsx.analysis.whirl import WhirlMeter
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


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
