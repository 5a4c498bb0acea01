"""The tables of events, by names of the user."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import pi
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import (
    AngularSpeed,
    Radians,
    Seconds,
    require_number,
)
from turbine_fenicsx.case.rules import Only, find_name
from turbine_fenicsx.case.schema import Also
from turbine_fenicsx.case.section import (
    NotNegative,
    Positive,
    Section,
    check_names,
)
from turbine_fenicsx.control.events import Event, EventKind
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible

STOPS = ("shut_down", "emergency_stop")
"""Kinds of events that turn the blades out of the wind."""

TURNING = ("start_up", "pitch_fault", *STOPS)
"""Kinds that have to do with the pitch."""


class EventCase(Section):
    """Something that happens at a ``time``, whatever the controller wants; NAME is yours.

    Tables ``[[event]]`` without names get the names ``event_1``, ``event_2`` and so on.

    Before ``"start_up"`` the generator is off and the blades stay as they are, then they turn at
    ``rate`` to where the controller wants them. In ``"shut_down"`` and ``"emergency_stop"`` they
    turn at ``rate`` to ``pitch``. After ``"grid_loss"`` the generator has no torque. In
    ``"pitch_fault"`` a ``blade`` does not follow any more. ``"brake"`` closes the brake in
    ``duration``.
    """

    kind: EventKind = "emergency_stop"
    """Kind of the event."""
    time: Annotated[Seconds, NotNegative] = 0.0
    """When it begins."""
    pitch: Annotated[
        Radians, Field(ge=-pi, le=pi), Only("kind", *STOPS), Plausible(0.0, 110.0 * DEGREE)
    ] = 0.5 * pi
    """Where the blades turn in a stop."""
    rate: Annotated[
        AngularSpeed,
        Positive,
        Only("kind", "start_up", *STOPS),
        Plausible(0.1 * DEGREE, 60.0 * DEGREE),
    ] = 8.0 * pi / 180.0
    """How fast the blades turn in a start or stop."""
    blade: Annotated[
        Literal[1, 2, 3], BeforeValidator(require_number), Only("kind", "pitch_fault")
    ] = 1
    """Number of the blade with a fault."""
    duration: Annotated[Seconds, NotNegative, Only("kind", "brake")] = 0.6
    """Time in which the brake closes."""

    @check("kind", "pitch.drive", "pitch.bearings", "drivetrain.brake_torque")
    def _check_needs(self, case: Any) -> str:
        """The turbine has what the event needs."""
        key = f'{find_name(case, self)}.kind = "{self.kind}"'
        if self.kind in TURNING and (not case.has_pitch_bearings or case.pitch.drive != "actuator"):
            where = "" if case.has_pitch_bearings else "pitch.bearings = true and "
            return f'{key}: expected {where}pitch.drive = "actuator"'
        if self.kind == "brake" and not case.drivetrain.brake_torque > 0.0:
            return f"{key}: expected drivetrain.brake_torque greater than 0"
        return ""

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Events happen."""
        if self.time > case.time.end:
            yield (
                f"{find_name(case, self)}.time = {self.time:g} s is after time.end = "
                f"{case.time.end:g} s, so it does not happen"
            )


def list_events(events: Mapping[str, EventCase]) -> Sequence[Event]:
    """Events in the order of their times."""
    found = [Event(**event.model_dump()) for event in events.values()]
    return sorted(found, key=lambda event: event.time)


def name_events(data: Any) -> Any:
    """Nested tables of a case in which events of a list ``[[event]]`` have names.

    Values other than tables are left to later checks.
    """
    events = data.get("event") if isinstance(data, Mapping) else None
    if not isinstance(events, list):
        return data
    return {**data, "event": {f"event_{k}": event for k, event in enumerate(events, start=1)}}


EventCases = Annotated[dict[str, EventCase], BeforeValidator(check_names), Also("array")]
"""Events by name."""
