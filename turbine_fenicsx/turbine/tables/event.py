"""The tables of events: their keys, and what they need of a turbine."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.quantities import (
    AngularSpeed,
    Radians,
    Seconds,
    require_number,
)
from turbine_fenicsx.case.section import (
    NotNegative,
    Positive,
    Section,
    check_names,
)
from turbine_fenicsx.control.events import EventKind


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
    pitch: Annotated[Radians, Field(ge=-pi, le=pi)] = 0.5 * pi
    """Where the blades turn in a stop."""
    rate: Annotated[AngularSpeed, Positive] = 8.0 * pi / 180.0
    """How fast the blades turn in a start or stop."""
    blade: Annotated[Literal[1, 2, 3], BeforeValidator(require_number)] = 1
    """Number of the blade with a fault."""
    duration: Annotated[Seconds, NotNegative] = 0.6
    """Time in which the brake closes."""


def name_events(data: Any) -> Any:
    """Nested tables of a case in which events of a list ``[[event]]`` have names.

    Values other than tables are left to later checks.
    """
    events = data.get("event") if isinstance(data, Mapping) else None
    if not isinstance(events, list):
        return data
    return {**data, "event": {f"event_{k}": event for k, event in enumerate(events, start=1)}}


EventCases = Annotated[dict[str, EventCase], BeforeValidator(check_names)]
"""Events by name."""
