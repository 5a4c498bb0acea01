"""The state in which the run of a case starts."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import NoEquilibrium, StepFailure
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.rotor_plan import plan_layout
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.flexible_blades import BODY as BLADES_BODY
from turbine_fenicsx.turbine.components.nacelle import ROTOR, YAW
from turbine_fenicsx.turbine.components.pitch import BEARINGS

log = logging.getLogger(__name__)

STILL: dict[str, Any] = {}
IN_WIND: dict[str, Any] = {"tolerance": 1e-9, "max_iterations": 60, "add_change": False}
"""Tolerance and iterations of a turning start in wind, see theory/turning. The tangent lacks air
loads, so that convergence is linear; an error of 1e-6 of the displacements would excite walls."""


def make_start(case: Case, system: MultibodySystem) -> State | None:
    """The state at t = 0: undeformed, in equilibrium, or turning.

    The rotor stands at its azimuth and the blades at their pitch, which are joint coordinates.
    Bearings that nothing drives are held while an equilibrium is found.

    Args:
        case: The case.
        system: The system of its turbine.

    Returns:
        The state; None for the initial state of the system.

    Raises:
        ModelError: if something else moves with the rotor, so that it cannot turn by itself.
        StepFailure: if there is no equilibrium.

    Note:
        Collective.
    """
    kind, speed, azimuth = case.time.start, case.turbine.rotor_speed, case.turbine.azimuth
    if kind == "undeformed" and speed == azimuth == 0.0 and not any(case.pitch.initial):
        return None
    state = system.initial_state()
    turn_blades(case, system, state)
    frame = turning_frame(system, ROTOR, speed, state)
    frame.turn(state, azimuth)
    held = list_held(case, system)
    try:
        if kind == "equilibrium":
            return equilibrium(system, state=state, held=held)
        if kind == "turning":
            accuracy = IN_WIND if case.wind.blows else STILL
            return turning_equilibrium(
                system, ROTOR, speed, state, periodic=True, held=held, **accuracy
            )
    except NoEquilibrium as failure:
        ramps = "time.ramp and wind.ramp" if case.wind.blows else "time.ramp"
        advice = f'time.start = "undeformed" with {ramps} lets the loads set in gradually'
        raise StepFailure(f'time.start = "{kind}": {failure.reason}; {advice}') from None
    frame.set_velocities(state)
    return state


def turn_blades(
    case: Case, system: MultibodySystem, state: State, pitch: Sequence[float] | None = None
) -> None:
    """Turn the blades of a state to a pitch, as if they were rigid.

    Args:
        state: The initial state, or another one in which the blades have been turned.
        pitch: Of each blade [rad]; that at which the run of the case starts if None.
    """
    if not case.has_pitch_bearings:
        return
    layout, names = plan_layout(case.turbine), system.joint_coordinate_names
    joints = {joint.name: joint for joint in system.joints}
    spans = np.array([layout.frame(k)[0] for k in range(1, layout.n_blades + 1)])
    angles = case.pitch.initial if pitch is None else pitch
    for k, (name, angle) in enumerate(zip(BEARINGS, angles, strict=True)):
        coordinate = OPENFAST_SIGNS[name] * angle
        turn = OPENFAST_SIGNS[name] * (coordinate - state.joint_coordinates[names.index(name)])
        if not turn:
            continue
        state.joint_coordinates[names.index(name)] = coordinate
        body = joints[name].bodies[1]
        assert body is not None
        first = system.first_coordinate[body]
        arms = state.q[first : first + 12].reshape(4, 3)
        # the axis of the bearing turns with hub and blade; pitch counts about it from tip to root
        turned = np.asarray(body.directors) @ arms[1:]
        centre = arms[0] + (np.asarray(layout.centre) - body.position) @ turned
        R = rotation_about(-spans[k] @ turned, turn)
        arms[0] -= centre
        arms[:] = arms @ R.T
        arms[0] += centre
        for model, u in zip(system.flexible_models, state.u, strict=True):
            if model.body.name == BLADES_BODY:
                mine = _find_blades(model, layout.centre, spans) == k
                x = (model.positions + u.array_r.reshape(-1, 3))[mine]
                origin = model.is_point[mine, None] * centre
                moved = (x - origin) @ R.T + origin
                u.array.reshape(-1, 3)[mine] = moved - model.positions[mine]


def _find_blades(model: BodyModel, centre: npt.ArrayLike, spans: Array) -> IntArray:
    """Number of the blade that each node belongs to, from 0.

    Args:
        centre: Rotor centre in the initial configuration, shape (3,) [m].
        spans: Directions of the blades, shape (blades, 3).
    """
    X = model.positions - model.is_point[:, None] * np.asarray(centre, dtype=float)
    if len(model.body.placements) > 1:  # nodes of one blade after another
        return np.arange(len(X)) * len(spans) // model.size_global
    blades: IntArray = np.argmax(X @ spans.T, axis=1)
    return blades


def list_held(case: Case, system: MultibodySystem) -> list[str]:
    """Joint coordinates that nothing but inertia keeps where they are."""
    free = [ROTOR, YAW, *(BEARINGS if case.pitch.drive == "free" else ())]
    return [name for name in free if name in system.joint_coordinate_names]
