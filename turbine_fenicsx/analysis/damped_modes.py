"""Modes of damped systems about an equilibrium."""

from __future__ import annotations

from turbine_fenicsx.analysis.complex_modes import check_count, complex_modes
from turbine_fenicsx.analysis.equilibrium_check import check_equilibrium
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.analysis.modes import find_rest
from turbine_fenicsx.analysis.quadratic_problem import QuadraticProblem
from turbine_fenicsx.analysis.slepc import import_slepc
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


def damped_modes(system: MultibodySystem, state: State | None = None, count: int = 12) -> Modes:
    """Modes about an equilibrium with dampers, viscous materials and other forces of the velocity.

    Args:
        system: The system.
        state: The equilibrium, with the multipliers of its constraint forces; None finds it.
        count: Number of modes. Where a motion is damped so strongly that it does not vibrate, both
            of its real eigenvalues count.

    Returns:
        The modes with the smallest eigenvalues, by rising frequency, with `Mode.damping_ratio`.
        `Modes.state` is the given state or that which was found; the caller frees it.

    Raises:
        InputError: if slepc4py is not installed.
        TypeError: if the state is not a `State`.
        ModelError: for a state that is not in equilibrium, more modes than degrees of freedom, or a
            force that has no derivative with respect to the velocity.
        StepFailure: if no equilibrium is found, or the iteration does not converge.

    Note:
        Collective.
    """
    import_slepc()
    if state is not None:
        check_equilibrium(system, state)
    with one_thread():
        rest = find_rest(system) if state is None else state
        linear = LinearSystem(system, rest)
        try:
            check_count(linear, count)
            problem = QuadraticProblem(linear, linear.mass, linear.damping, linear.stiffness)
            return Modes(rest, complex_modes(problem, count)[0])
        finally:
            linear.destroy()
