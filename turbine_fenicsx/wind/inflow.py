"""The wind where there is no turbine: uniform over the ground, with shear, from a direction.

Axes are those of the wind: x downwind of the mean direction, z up from the ground, y = z x x.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.time_functions import Ramp
from turbine_fenicsx.foundation.argument_checks import (
    check_array,
    check_not_negative,
    check_number,
    check_positive,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

FASTEST = 200.0
"""No wind is faster [m/s]; a file that has more is damaged, or in other units."""


class Inflow(Protocol):
    """Any wind: a function of place and time."""

    def velocity(self, position: Array, time: float) -> Array:
        """Velocity of the air.

        Args:
            position: Places, x downwind of the tower, z above ground, shape (..., 3) [m].
            time: Time [s].

        Returns:
            Shape (..., 3) [m/s].
        """


@dataclass(frozen=True, eq=False)
class PlacedInflow:
    """A wind in the axes of a model.

    Args:
        inflow: The wind in other axes.
        axes: Its axes x, y, z as rows in those of the model, orthonormal, shape (3, 3).
        ground: Point on the ground below the tower in the model, shape (3,) [m].

    Raises:
        ModelError: for axes that are not orthonormal and right-handed.
    """

    inflow: Inflow
    axes: npt.ArrayLike
    ground: npt.ArrayLike

    def __post_init__(self) -> None:
        axes = check_array("axes of the wind", self.axes, (3, 3), "three vectors")
        check_array("ground of the wind", self.ground, (3,), "three numbers")
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) or np.linalg.det(axes) < 0.0:
            raise ModelError("axes of the wind must be orthonormal and right-handed")

    def velocity(self, position: Array, time: float) -> Array:
        """Velocity of the air at places of the model, shape (..., 3) [m/s]."""
        axes = np.asarray(self.axes, dtype=float)
        local = (position - np.asarray(self.ground, dtype=float)) @ axes.T
        return np.asarray(self.inflow.velocity(local, time) @ axes)


@dataclass(frozen=True)
class SteadyWind:
    """Wind that grows over height by a power law.

    Args:
        speed: At the height of the hub [m/s].
        hub_height: Height of the hub above ground [m].
        shear: Exponent of the power law; 0 for the same wind everywhere [-].
        direction: Angle of the wind with x, positive from x to y [rad].
        inclination: Upward angle of the wind [rad].

    Raises:
        ModelError: if the speed is negative, the height is not positive, or an argument is not a
            number.
    """

    speed: float
    hub_height: float = 100.0
    shear: float = 0.0
    direction: float = 0.0
    inclination: float = 0.0

    def __post_init__(self) -> None:
        check_not_negative("wind speed", self.speed)
        check_positive("hub height of the wind", self.hub_height)
        check_not_negative("shear of the wind", self.shear)
        for what in ("direction", "inclination"):
            check_number(f"{what} of the wind", getattr(self, what))

    def velocity(self, position: Array, time: float) -> Array:
        """V = V_hub (z/z_hub)^alpha along the direction, zero on and below the ground."""
        return self.at_heights(np.asarray(position)[..., 2])[..., None] * self.unit_vector

    def at_heights(self, height: Array) -> Array:
        """Speeds at heights above ground, in their shape [m/s]."""
        profile = (np.maximum(height, 0.0) / self.hub_height) ** self.shear
        return np.asarray(self.speed * profile)

    @cached_property
    def unit_vector(self) -> Array:
        """Direction of the wind, shape (3,)."""
        return turn(self.direction, self.inclination)


def turn(direction: float, inclination: float = 0.0) -> Array:
    """Unit vector at an angle from x towards y and an upward angle, shape (3,)."""
    level = np.cos(inclination)
    return np.array([level * np.cos(direction), level * np.sin(direction), np.sin(inclination)])


def check_one_of(what: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise a ModelError unless a word is one of those allowed."""
    if value not in choices:
        allowed = ", ".join(repr(choice) for choice in choices)
        raise ModelError(f"{what} must be one of {allowed}, got {value!r}")


@dataclass(frozen=True, eq=False)
class RampedInflow:
    """Another wind times a ramp that begins at t = 0.

    Args:
        duration: Time in which it sets in, positive [s].
    """

    inflow: Inflow
    duration: float

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`."""
        factor = Ramp(1.0, self.duration, smooth=True)(time)
        return np.asarray(factor * self.inflow.velocity(position, time))
