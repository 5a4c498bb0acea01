"""A steady wind whose speed and direction are set from outside."""

from __future__ import annotations

from dataclasses import replace

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import SteadyWind


class SettableWind:
    """An `Inflow` like `SteadyWind`, for a sequence of equilibria.

    Args:
        wind: The wind until another speed is set.
    """

    def __init__(self, wind: SteadyWind) -> None:
        self._wind = wind

    def set_speed(self, speed: float) -> None:
        """Blow at this speed at the height of the hub from now on [m/s]."""
        self._wind = replace(self._wind, speed=speed)

    @property
    def angles(self) -> tuple[float, float]:
        """Direction and upward angle [rad]."""
        return self._wind.direction, self._wind.inclination

    def set_angles(self, direction: float, inclination: float) -> None:
        """Blow in this direction from now on [rad]."""
        self._wind = replace(self._wind, direction=direction, inclination=inclination)

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`."""
        return self._wind.velocity(position, time)
