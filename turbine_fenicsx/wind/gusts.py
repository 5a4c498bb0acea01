"""The transient winds of IEC 61400-1, edition 3, section 6.3: gusts, turns and shears.

All begin at a time of choice; before, the wind is steady with the normal wind profile.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from turbine_fenicsx.foundation.argument_checks import (
    check_not_negative,
    check_number,
    check_positive,
)
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import SteadyWind, check_one_of, turn

REFERENCE_SPEEDS = {"I": 50.0, "II": 42.5, "III": 37.5}
"""V_ref of the classes, table 1 [m/s]."""

INTENSITIES = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}
"""I_ref of the categories of turbulence, table 1; A+ from edition 4 [-]."""

NORMAL_SHEAR = 0.2
"""Exponent of the normal wind profile, section 6.3.1.2."""

GUST_TIME, TURN_TIME, COHERENT_TIME, SHEAR_TIME = 10.5, 6.0, 10.0, 12.0
"""Durations T of the four transients [s]."""

COHERENT_RISE = 15.0
"""V_cg, section 6.3.2.5 [m/s]."""


@dataclass(frozen=True)
class TurbineClass:
    """Class of wind and category of turbulence, for example I and B."""

    wind: str = "I"
    turbulence: str = "B"

    def __post_init__(self) -> None:
        check_one_of("class of the turbine", self.wind, tuple(REFERENCE_SPEEDS))
        check_one_of("category of turbulence", self.turbulence, tuple(INTENSITIES))

    @property
    def reference_speed(self) -> float:
        """V_ref [m/s]."""
        return REFERENCE_SPEEDS[self.wind]

    def normal_deviation(self, speed: float) -> float:
        """Standard deviation sigma_1 of normal turbulence, section 6.3.1.3 [m/s]."""
        return INTENSITIES[self.turbulence] * (0.75 * speed + 5.6)

    def extreme_deviation(self, speed: float) -> float:
        """Standard deviation sigma_1 of extreme turbulence, section 6.3.2.3 [m/s]."""
        c, mean = 2.0, 0.2 * self.reference_speed
        level = 0.072 * (mean / c + 3.0) * (speed / c - 4.0) + 10.0
        return c * INTENSITIES[self.turbulence] * level


@dataclass(frozen=True)
class _Transient:
    """Base of the transients.

    Args:
        speed: At the height of the hub before [m/s].
        hub_height: Height of the hub [m].
        diameter: Of the rotor [m].
        start: When it begins [s].
        shear: Exponent of the wind profile [-].
        direction: Angle of the wind before, from x towards y [rad].
    """

    speed: float
    hub_height: float
    diameter: float
    start: float = 0.0
    turbine_class: TurbineClass = TurbineClass()
    shear: float = NORMAL_SHEAR
    direction: float = 0.0

    def __post_init__(self) -> None:
        for what in ("speed", "hub_height", "diameter"):
            check_positive(f"{what.replace('_', ' ')} of a gust", getattr(self, what))
        check_not_negative("shear of a gust", self.shear)
        for what in ("start", "direction"):
            check_number(f"{what} of a gust", getattr(self, what))

    @cached_property
    def _steady(self) -> SteadyWind:
        return SteadyWind(self.speed, self.hub_height, self.shear, self.direction)

    @property
    def scale(self) -> float:
        """Length Lambda_1 of turbulence, section 6.3 [m]."""
        return 0.7 * min(self.hub_height, 60.0)

    @property
    def _reduced_deviation(self) -> float:
        """The deviation sigma_1 over the rotor, sigma_1/(1 + 0.1 D/Lambda_1) [m/s]."""
        sigma = self.turbine_class.normal_deviation(self.speed)
        return sigma / (1.0 + 0.1 * self.diameter / self.scale)

    def _phase(self, time: float, duration: float) -> float:
        """Part of the transient that is over, from 0 to 1."""
        return min(max((time - self.start) / duration, 0.0), 1.0)


class OperatingGust(_Transient):
    """Extreme operating gust, EOG, section 6.3.2.2."""

    @property
    def amplitude(self) -> float:
        """V_gust [m/s]."""
        once_a_year = 0.8 * 1.4 * self.turbine_class.reference_speed
        return min(1.35 * (once_a_year - self.speed), 3.3 * self._reduced_deviation)

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`: a dip, a rise and a dip."""
        phase = self._phase(time, GUST_TIME)
        change = np.sin(3.0 * np.pi * phase) * (1.0 - np.cos(2.0 * np.pi * phase))
        speed = self._steady.at_heights(np.asarray(position)[..., 2])
        return np.asarray(
            (speed - 0.37 * self.amplitude * change)[..., None] * turn(self.direction)
        )


@dataclass(frozen=True)
class DirectionChange(_Transient):
    """Extreme direction change, EDC, section 6.3.2.4.

    Args:
        sign: 1 for a turn from x to y, -1 for the other.
    """

    sign: int = 1

    @property
    def amplitude(self) -> float:
        """theta_e, at most half a turn [rad]."""
        angle = 4.0 * np.arctan(self._reduced_deviation / self.speed)
        return float(min(angle, np.pi))

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`: the wind turns and stays turned."""
        rise = 0.5 * (1.0 - np.cos(np.pi * self._phase(time, TURN_TIME)))
        direction = self.direction + self.sign * self.amplitude * rise
        speed = self._steady.at_heights(np.asarray(position)[..., 2])
        return np.asarray(speed[..., None] * turn(direction))


@dataclass(frozen=True)
class CoherentGust(_Transient):
    """Extreme coherent gust with direction change, ECD, section 6.3.2.5.

    Args:
        sign: 1 for a turn from x to y, -1 for the other.
    """

    sign: int = 1

    @property
    def amplitude(self) -> float:
        """theta_cg [rad]."""
        return float(np.pi if self.speed < 4.0 else np.radians(720.0) / self.speed)

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`: the wind rises by 15 m/s, turns, and stays so."""
        rise = 0.5 * (1.0 - np.cos(np.pi * self._phase(time, COHERENT_TIME)))
        direction = self.direction + self.sign * self.amplitude * rise
        speed = self._steady.at_heights(np.asarray(position)[..., 2]) + COHERENT_RISE * rise
        return np.asarray(speed[..., None] * turn(direction))


@dataclass(frozen=True)
class WindShear(_Transient):
    """Extreme wind shear, EWS, section 6.3.2.6.

    Args:
        sign: 1 for more wind above, or at positive y; -1 for the other.
        horizontal: Whether the wind changes across the rotor and not over its height.
    """

    sign: int = 1
    horizontal: bool = False

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`."""
        position = np.asarray(position)
        sigma = self.turbine_class.normal_deviation(self.speed)
        phase = self._phase(time, SHEAR_TIME)
        size = 2.5 + 0.2 * 6.4 * sigma * (self.diameter / self.scale) ** 0.25
        if self.horizontal:
            c, s = np.cos(self.direction), np.sin(self.direction)
            lever = c * position[..., 1] - s * position[..., 0]
        else:
            lever = position[..., 2] - self.hub_height
        change = lever / self.diameter * size * (1.0 - np.cos(2.0 * np.pi * phase))
        speed = self._steady.at_heights(position[..., 2]) + self.sign * change
        return np.asarray(speed[..., None] * turn(self.direction))
