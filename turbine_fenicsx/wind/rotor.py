"""Line loads, thrust, torque and power of a rotor that turns steadily in steady wind."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.argument_checks import (
    check_not_negative,
    check_number,
    check_positive,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.momentum import Annuli, Induction, find_induction_share, solve_momentum


@dataclass(frozen=True)
class Rotor:
    """Equal blades on a hub in front of the tower.

    Args:
        blade: One of the blades.
        blades: Their number.
        precone: Angle of the blades with the rotor plane, positive if tips are upwind [rad].
        tilt: Angle of the shaft with the horizontal, positive if the hub is its upper end [rad].
        hub_height: Height of the rotor centre above ground [m].
        induction: Whether the rotor changes the wind. A rotor that hardly turns does not; see
            `turbine_fenicsx.wind.momentum.find_induction_share`.
    """

    blade: AeroBlade
    blades: int = 3
    precone: float = 0.0
    tilt: float = 0.0
    hub_height: float = 100.0
    induction: bool = True

    def __post_init__(self) -> None:
        if self.blades < 1:
            raise ModelError(f"a rotor needs at least one blade, got {self.blades}")
        check_positive("hub height of the rotor", self.hub_height)
        for what in ("precone", "tilt"):
            if not abs(check_number(f"{what} of the rotor", getattr(self, what))) < 0.5 * np.pi:
                raise ModelError(f"{what} of the rotor must be below 90 degrees")

    @property
    def _slope(self) -> Array:
        """Angles of all sections with the rotor plane, positive upwind, shape (n,) [rad]."""
        blade = self.blade
        if blade.prebend is None:
            return np.full(len(blade.radius), self.precone)
        return np.asarray(self.precone - np.arctan(np.gradient(blade.prebend, blade.radius)))

    @property
    def _places(self) -> tuple[Array, Array]:
        """Distances of all stations from the shaft, and downwind of the rotor centre, (n,) [m]."""
        r, x = self.blade.radius, self.blade.prebend
        x = np.zeros(len(r)) if x is None else x
        c, s = np.cos(self.precone), np.sin(self.precone)
        return r * c + x * s, x * c - r * s

    @property
    def tip_distance(self) -> float:
        """Distance of the tips from the shaft, the radius of the swept area [m]."""
        blade = self.blade
        x = 0.0 if blade.prebend is None else float(blade.prebend[-1])
        return float(blade.tip_radius * np.cos(self.precone) + x * np.sin(self.precone))


@dataclass(frozen=True)
class Operation:
    """How a rotor runs.

    Args:
        wind_speed: At the height of the hub [m/s].
        rotor_speed: Not negative [rad/s].
        pitch: Of all blades, positive towards feather [rad].
        yaw: Angle of the wind with the vertical plane of the shaft [rad].
        shear: Exponent of the power law of the wind over height [-].
        density: Of the air [kg/m^3].
    """

    wind_speed: float
    rotor_speed: float
    pitch: float = 0.0
    yaw: float = 0.0
    shear: float = 0.0
    density: float = 1.225

    def __post_init__(self) -> None:
        for what in ("wind_speed", "density"):
            check_positive(f"{what.replace('_', ' ')} of an operation", getattr(self, what))
        for what in ("rotor_speed", "shear"):
            check_not_negative(f"{what.replace('_', ' ')} of an operation", getattr(self, what))
        for what in ("pitch", "yaw"):
            check_number(f"{what} of an operation", getattr(self, what))


class LineForces(NamedTuple):
    """Loads on sections at azimuths, each of shape (m, n), and the induction there.

    Attributes:
        normal: Normal to the span and to the way of the section, downwind [N/m].
        tangential: Along the way of the section, driving the rotor [N/m].
        moment: About the span, nose up [N m/m].
    """

    normal: Array
    tangential: Array
    moment: Array
    induction: Induction


class Performance(NamedTuple):
    """Mean over a revolution: thrust [N], torque [N m], power [W], C_T and C_P [-]."""

    thrust: float
    torque: float
    power: float
    thrust_coefficient: float
    power_coefficient: float


def find_section_loads(
    rotor: Rotor, operation: Operation, azimuths: Array, wake: Operation | None = None
) -> LineForces:
    """Line loads of a blade at azimuths, where every annulus is in balance with its own wind.

    Args:
        rotor: The rotor.
        operation: How it runs.
        azimuths: From the upward position, in the sense of rotation, shape (m,) [rad].
        wake: An operation with the same wind and speed but another pitch, whose induction lasts, as
            in the first moments after a change of the pitch; that of ``operation`` by default.
    """
    blade = rotor.blade
    V_x, V_y = _relative_wind(rotor, operation, np.asarray(azimuths, dtype=float))
    before = blade.twist + (operation if wake is None else wake).pitch
    solidity = rotor.blades * blade.chord / (2.0 * np.pi * blade.radius)
    annuli = Annuli(blade.radius, solidity, rotor.blades, blade.tip_radius, blade.hub_radius)
    setting = blade.twist + operation.pitch

    def lift_and_drag(phi: Array) -> tuple[Array, Array]:
        found = blade.table(phi - before)
        return found.lift, found.drag

    tip_speed = operation.rotor_speed * rotor.tip_distance
    share = find_induction_share(tip_speed, operation.wind_speed) if rotor.induction else 0.0
    induction = solve_momentum(annuli, V_x, V_y, lift_and_drag, share)
    phi, a, a_prime = induction
    C = blade.table(phi - setting)
    W_2 = (V_x * (1.0 - a)) ** 2 + (V_y * (1.0 + a_prime)) ** 2
    q = 0.5 * operation.density * W_2 * blade.chord
    s, c = np.sin(phi), np.cos(phi)
    normal, tangential = q * (C.lift * c + C.drag * s), q * (C.lift * s - C.drag * c)
    return LineForces(normal, tangential, q * blade.chord * C.moment, induction)


def find_performance(
    rotor: Rotor, operation: Operation, sectors: int = 8, wake: Operation | None = None
) -> Performance:
    """Thrust, torque and power, those of the moments about coned or bent spans included.

    Args:
        rotor: The rotor.
        operation: How it runs.
        sectors: Number of azimuths over which loads are averaged; one is enough where all of them
            are alike.
        wake: As in `find_section_loads`.
    """
    blade = rotor.blade
    azimuths = 2.0 * np.pi * np.arange(sectors) / sectors
    loads = find_section_loads(rotor, operation, azimuths, wake)
    distance, _ = rotor._places
    # length of the span over that of the radius, and the part of the normal loads along the shaft
    slope = rotor._slope
    arc = np.cos(rotor.precone) / np.cos(slope) if blade.prebend is not None else 1.0
    normal, tangential, moment = (np.mean(x, axis=0) for x in loads[:3])
    along = normal * np.cos(slope) * arc
    # a span that leans upwind has the part -sin(slope) along the shaft
    about = (tangential * distance - moment * np.sin(slope)) * arc
    thrust, torque = (rotor.blades * float(blade.parts @ f) for f in (along, about))
    V, area = operation.wind_speed, np.pi * rotor.tip_distance**2
    pressure = 0.5 * operation.density * V * V
    power = torque * operation.rotor_speed
    return Performance(
        thrust, torque, power, thrust / (pressure * area), power / (pressure * V * area)
    )


def find_pitch(
    rotor: Rotor,
    operation: Operation,
    power: float,
    interval: tuple[float, float],
    sectors: int = 1,
    accuracy: float = 1e-10,
) -> float:
    """Pitch at which the rotor takes a power out of the wind.

    Args:
        rotor: The rotor.
        operation: How it runs but for the pitch.
        power: [W].
        interval: Pitch angles at which power is above and below what is wanted [rad].
        sectors: As in `find_performance`.
        accuracy: Of the pitch [rad].

    Returns:
        The pitch [rad].

    Raises:
        ModelError: if power is not crossed within the interval.
    """
    from scipy.optimize import brentq

    def lacking(pitch: float) -> float:
        return find_performance(rotor, replace(operation, pitch=pitch), sectors).power - power

    ends = [lacking(pitch) for pitch in interval]
    if not ends[0] * ends[1] <= 0.0:
        low, high = np.degrees(interval)
        raise ModelError(
            f"no pitch between {low:g} and {high:g} degrees gives {1e-6 * power:g} MW at "
            f"{operation.wind_speed:g} m/s; the ends give {1e-6 * (ends[0] + power):g} and "
            f"{1e-6 * (ends[1] + power):g} MW"
        )
    return float(brentq(lacking, *interval, xtol=accuracy))


def _relative_wind(rotor: Rotor, operation: Operation, azimuths: Array) -> tuple[Array, Array]:
    """Wind that sections feel along their normals and against their way, shape (m, n) [m/s].

    In the frame of the ground x is downwind, z up and y = z x x.
    """
    c, s = np.cos(rotor.tilt), np.sin(rotor.tilt)
    x, z = np.array([c, 0.0, -s]), np.array([s, 0.0, c])  # shaft, and up in the rotor plane
    y = np.cross(z, x)
    cos, sin = np.cos(azimuths)[:, None, None], np.sin(azimuths)[:, None, None]
    radial, way = cos * z - sin * y, -sin * z - cos * y
    distance, downwind = rotor._places
    position = distance[:, None] * radial + downwind[:, None] * x
    height = rotor.hub_height + position[..., 2]
    if not np.all(height > 0.0):
        raise ModelError(
            f"the tips reach the ground: they are {rotor.tip_distance:g} m from the shaft at a hub "
            f"height of {rotor.hub_height:g} m"
        )
    speed = operation.wind_speed * (height / rotor.hub_height) ** operation.shear
    direction = np.array([np.cos(operation.yaw), np.sin(operation.yaw), 0.0])
    wind = speed[..., None] * direction
    slope = rotor._slope[:, None]
    normal = np.cos(slope) * x + np.sin(slope) * radial
    V_x = np.sum(wind * normal, axis=-1)
    V_y = operation.rotor_speed * distance - np.sum(wind * way, axis=-1)
    return V_x, V_y
