"""Measurements and commands of a controller.

Speeds are positive when the rotor turns as it should, pitch angles when they are towards feather.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

BLADES = 3

Angles = tuple[float, float, float]

_SEVERAL = {"pitch": BLADES, "flap_moments": BLADES, "edge_moments": BLADES, "top_acceleration": 2}
"""Measurements of more than one number."""


class Measurements(NamedTuple):
    """Measurements at the end of a step.

    Attributes:
        time: Time [s].
        dt: Time since the last call; at the first call the step that comes [s].
        first: Whether this is the first call of a run.
        generator_speed: Of the fast shaft [rad/s].
        rotor_speed: Of the hub [rad/s].
        azimuth: Of blade 1, zero where it points up [rad].
        pitch: Of the blades [rad].
        generator_torque: Of the last step, on the fast shaft, braking it [N m].
        electrical_power: Of the last step [W].
        wind_speed: Horizontal, at the hub, without the rotor [m/s]; zero without wind.
        yaw: Of the nacelle, about the upward vertical [rad].
        yaw_error: Direction of the wind minus that of the nacelle [rad].
        flap_moments: Of the blades on the hub at their roots, out of the plane of the rotor,
            positive if they push the tips downwind; means of the last step, zero at the first call
            [N m].
        edge_moments: In the plane of the rotor, positive if they push the tips to where they come
            from [N m].
        top_acceleration: Of the tower's top, downwind and to the left looking downwind, zero
            without a flexible tower [m/s^2].
    """

    time: float
    dt: float
    first: bool
    generator_speed: float
    rotor_speed: float
    azimuth: float
    pitch: Angles
    generator_torque: float
    electrical_power: float
    wind_speed: float = 0.0
    yaw: float = 0.0
    yaw_error: float = 0.0
    flap_moments: Angles = (0.0, 0.0, 0.0)
    edge_moments: Angles = (0.0, 0.0, 0.0)
    top_acceleration: tuple[float, float] = (0.0, 0.0)

    def to_row(self) -> list[float]:
        """All numbers in a list."""
        row: list[float] = []
        for value in self:
            row.extend(map(float, value) if isinstance(value, tuple) else [float(value)])
        return row

    @classmethod
    def from_row(cls, row: Array) -> Measurements:
        """The measurements of a list of numbers."""
        numbers = iter(np.asarray(row, dtype=float).tolist())
        found: dict[str, Any] = {}
        for name in cls._fields:
            if name in _SEVERAL:
                found[name] = tuple(next(numbers) for _ in range(_SEVERAL[name]))
            else:
                found[name] = next(numbers)
        found["first"] = bool(found["first"])
        return cls(**found)


class Commands(NamedTuple):
    """Commands that hold until the next call.

    Attributes:
        generator_torque: On the fast shaft, positive if it brakes the rotor [N m].
        pitch: Of the blades [rad].
        yaw_rate: Of the nacelle, about the upward vertical [rad/s].
        brake: Share of the torque of the shaft brake, from 0 (open) to 1.
    """

    generator_torque: float
    pitch: Angles
    yaw_rate: float = 0.0
    brake: float = 0.0

    def to_row(self) -> list[float]:
        """All numbers in a list."""
        return [self.generator_torque, *self.pitch, self.yaw_rate, self.brake]


@runtime_checkable
class Controller(Protocol):
    """Anything that commands a turbine. All ranks call it with the same measurements."""

    def command(self, measured: Measurements) -> Commands:
        """Commands for the next step; called at the start and after every accepted step."""

    def save(self) -> RestartData:
        """Its state for a restart. Collective."""

    def restore(self, data: RestartData) -> None:
        """Restore the state of the controller that saved this. Collective."""

    def finish(self) -> None:
        """The run has ended. Collective."""
