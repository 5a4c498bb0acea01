"""Checks of controller, drivetrain, yaw bearing and events against each other and the turbine."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from turbine_fenicsx.case.section import UnusedKeys
from turbine_fenicsx.control.discon import check_library
from turbine_fenicsx.control.events import Event
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.turbine.tables.tables import Tables

TURNING = ("start_up", "shut_down", "emergency_stop", "pitch_fault")
"""Kinds that have to do with the pitch."""

STOPS = ("shut_down", "emergency_stop")


def check_control(case: Tables) -> str:
    """The controller is there and has something to act on."""
    c = case.control
    if c.kind == "none":
        return ""
    key = f'control.kind = "{c.kind}"'
    if not case.has_pitch_bearings:
        return f"{key}: expected pitch.bearings = true, a controller turns the blades"
    if case.pitch.drive != "actuator":
        return f'{key}: expected pitch.drive = "actuator", got "{case.pitch.drive}"'
    if c.kind == "discon":
        for name in ("library", "input"):
            if getattr(c, name) is None:
                return f"{key}: expected control.{name}, the name of a file"
        assert c.library and c.input
        return check_library(Path(c.library), Path(c.input))
    if c.python_class and not c.python_class[0].is_file():
        return f"{key}: there is no file '{c.python_class[0]}'"
    return ""


def check_torque_law(case: Tables) -> str:
    """Regions of the torque follow each other."""
    return _check_law("torque", case)


def check_pitch_law(case: Tables) -> str:
    """Limits of the pitch leave some."""
    return _check_law("pitch", case)


def _check_law(name: str, case: Tables) -> str:
    """Complaint about a law."""
    if case.control.kind != "pi":
        return ""
    try:
        getattr(case.control, name).make()
    except ModelError as error:
        return f"control.{name}: {error}"
    return ""


def check_drivetrain(case: Tables) -> str:
    """Checks of the drivetrain."""
    d = case.drivetrain
    if d.model == "none":
        return ""
    if not d.generator_inertia > 0.0:
        return (
            f'drivetrain.generator_inertia = 0: expected more than 0 with drivetrain.model = "'
            f'{d.model}"'
        )
    if d.model == "two_mass" and not d.stiffness > 0.0:
        return 'drivetrain.stiffness = 0: expected more than 0 with drivetrain.model = "two_mass"'
    return ""


def list_events(case: Tables) -> Sequence[Event]:
    """The events of a case in the order of their times."""
    events = [Event(**event.model_dump()) for event in case.event.values()]
    return sorted(events, key=lambda event: event.time)


def has_brake(case: Tables) -> bool:
    """Whether an event or a controller from outside may close a brake that has a torque."""
    c = case.control
    foreign = c.kind == "discon" or c.python_class is not None
    by_event = any(event.kind == "brake" for event in case.event.values())
    return by_event or (foreign and case.drivetrain.brake_torque > 0.0)


def check_events(case: Tables) -> str:
    """The turbine has what its events need."""
    for name, event in case.event.items():
        key = f'event.{name}.kind = "{event.kind}"'
        if event.kind in TURNING and (
            not case.has_pitch_bearings or case.pitch.drive != "actuator"
        ):
            where = "" if case.has_pitch_bearings else "pitch.bearings = true and "
            return f'{key}: expected {where}pitch.drive = "actuator"'
        if event.kind == "brake" and not case.drivetrain.brake_torque > 0.0:
            return f"{key}: expected drivetrain.brake_torque greater than 0"
    return ""


CONTROL_CHECKS = (
    (("control", "pitch.drive", "pitch.bearings", "turbine.model"), check_control),
    (("control.torque",), check_torque_law),
    (("control.pitch",), check_pitch_law),
    (("drivetrain",), check_drivetrain),
    (("event", "pitch.drive", "pitch.bearings", "drivetrain.brake_torque"), check_events),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""


def find_unused_control_keys(case: Tables) -> UnusedKeys:
    """Keys without effect."""
    kind = case.control.kind
    if kind != "pi":
        reason = f'with control.kind = "{kind}"'
        yield "control", ("filter_frequency", "torque", "pitch"), reason
    if kind != "discon":
        yield "control", ("library", "input"), f'with control.kind = "{kind}"'
    yield from _find_unused_drivetrain_keys(case)
    yield from _find_unused_event_keys(case)


def _find_unused_drivetrain_keys(case: Tables) -> UnusedKeys:
    """Keys without effect."""
    d = case.drivetrain
    reason = f'with drivetrain.model = "{d.model}"'
    if d.model == "none":
        yield "drivetrain", ("generator_inertia", "mass"), reason
    if d.model != "two_mass":
        yield "drivetrain", ("stiffness", "damping"), reason
    if case.control.kind == "none":
        yield "drivetrain", ("efficiency",), 'with control.kind = "none"'
        if d.model == "none":
            yield "drivetrain", ("ratio",), 'with control.kind = "none"'
    if d.brake_torque and not has_brake(case):
        yield "drivetrain", ("brake_torque",), 'without an event of kind "brake"'
    if case.yaw.drive != "free":
        yield "loads", ("yaw_torque",), f'with yaw.drive = "{case.yaw.drive}"'


def _find_unused_event_keys(case: Tables) -> UnusedKeys:
    """Keys of other kinds of events."""
    for name, event in case.event.items():
        idle = {"pitch", "rate", "blade", "duration"}
        if event.kind in (*STOPS, "start_up"):
            idle -= {"rate"}
        if event.kind in STOPS:
            idle -= {"pitch"}
        idle -= {"pitch_fault": {"blade"}, "brake": {"duration"}}.get(event.kind, set())
        yield f"event.{name}", tuple(idle), f'with event.{name}.kind = "{event.kind}"'
