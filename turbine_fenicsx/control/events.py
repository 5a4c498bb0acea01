"""Events at set times, whatever the controller wants: starts, stops, faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from turbine_fenicsx.control.interface import Angles, Commands, Measurements
from turbine_fenicsx.control.pi import approach

EventKind = Literal["start_up", "shut_down", "emergency_stop", "grid_loss", "pitch_fault", "brake"]

BRAKE_TIME = 0.6
"""In which a brake closes or opens where the controller commands it [s]."""

ROUND_OFF = 1e-9
"""An event is due if its time is this much ahead [s]."""


@dataclass(frozen=True)
class Event:
    """Something that happens at a time.

    Args:
        time: When it begins [s].
        kind: ``"start_up"``: before it the generator is off and the blades stay; then they follow
            the controller. ``"shut_down"``, ``"emergency_stop"``: the blades turn to ``pitch``,
            whatever the controller wants. ``"grid_loss"``: the generator loses its torque.
            ``"pitch_fault"``: a blade stops following. ``"brake"``: the brake closes.
        pitch: Where the blades turn in a stop [rad].
        rate: How fast they turn in a start or stop [rad/s].
        blade: Number of the blade with a fault, from 1.
        duration: Time in which the brake closes [s].
    """

    time: float
    kind: EventKind
    pitch: float = 1.570796
    rate: float = 0.1396263
    blade: int = 1
    duration: float = BRAKE_TIME


class Orders(NamedTuple):
    """Orders for a step.

    Attributes:
        generator_torque: On the fast shaft [N m].
        pitch: Commands to the pitch drives [rad].
        yaw_rate: Command to the yaw drive [rad/s].
        brake: Part of the torque of the brake, 0 to 1.
        started: Whether a start-up has come to its end.
    """

    generator_torque: float
    pitch: Angles
    yaw_rate: float = 0.0
    brake: float = 0.0
    started: bool = False


def supervise(
    events: Sequence[Event], measured: Measurements, commands: Commands, before: Orders
) -> Orders:
    """Orders that remain of a controller's commands.

    Args:
        before: What was done in the last step; at the first call the pitch at the start.

    Returns:
        What is done in the next step.
    """
    due = [event for event in events if event.time <= measured.time + ROUND_OFF]
    torque, pitch, started = commands.generator_torque, commands.pitch, before.started
    brake = approach(before.brake, commands.brake, measured.dt / BRAKE_TIME)
    for event in events:
        if event.kind != "start_up":
            continue
        if event not in due:
            torque, pitch = 0.0, before.pitch
        elif not started:
            pitch = _approach(before.pitch, commands.pitch, event.rate * measured.dt)
            started = pitch == commands.pitch
    stops = [event for event in due if event.kind in ("shut_down", "emergency_stop")]
    if stops:
        last = max(stops, key=lambda event: event.time)
        target = (last.pitch, last.pitch, last.pitch)
        pitch = _approach(before.pitch, target, last.rate * measured.dt)
    for event in due:
        if event.kind == "grid_loss":
            torque = 0.0
        elif event.kind == "brake":
            since = max(measured.time - event.time, 0.0)
            brake = max(brake, min(since / event.duration, 1.0) if event.duration else 1.0)
        elif event.kind == "pitch_fault":
            k = event.blade - 1
            pitch = (*pitch[:k], before.pitch[k], *pitch[k + 1 :])  # type: ignore[assignment]
    return Orders(torque, pitch, commands.yaw_rate, brake, started)


def _approach(values: Angles, targets: Angles, most: float) -> Angles:
    """Angles moved towards targets by no more than so much."""
    a, b, c = (approach(v, t, most) for v, t in zip(values, targets, strict=True))
    return a, b, c
