"""The controller of a case as a windIO file has it, with gains from its aerodynamics.

Any controller turns the blades by the pitch drives of the file; the built-in one has its laws from
there as well. Speeds of the torque law stand to the rated speed as those of the NREL 5 MW turbine
do: region 3 begins a hundredth below it, region 2 at 1.3 times the smallest speed
(NREL/TP-500-38060, section 7.2). The gain of region 2 keeps the best tip-speed ratio, but is never
so large that K w^2 exceeds the rated torque before rated speed, which region 2 1/2 needs.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from turbine_fenicsx.case.quantities import to_si
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.turbine.tables.control import is_controller

if TYPE_CHECKING:  # cases without a file do not wait for what reads one
    from turbine_fenicsx.wind.rotor import Rotor
    from turbine_fenicsx.windio import WindIOTurbine
    from turbine_fenicsx.windio.control import ControllerData

BELOW_RATED, REGION_2, SLIP = 0.99, 1.3, 0.1
"""Beginnings of regions 3 and 2 as parts of rated and smallest speed; slip of region 2 1/2."""

STATIONS = 16
"""Of the blade; twice as many change the gains by 1 %."""

TORQUE_MARGIN, TORQUE_TIME = 1.1, 3.0
"""Where a file has none: largest torque over the rated one, time in which it may be reached [s]."""

LEAST_SPEED, PITCH_RATE = 0.6, 2.0 * pi / 180.0
"""Where a file has none: smallest speed over the rated one, and rate of the pitch [rad/s]."""


@dataclass(frozen=True)
class GeneratorShaft:
    """Actuators of a controller.

    Args:
        ratio: Speed of the generator over that of the rotor.
        built_in: Whether the controller is the built-in one.
    """

    ratio: float
    efficiency: float
    built_in: bool = True


def find_generator(data: Mapping[str, Any], turbine: WindIOTurbine) -> GeneratorShaft | None:
    """The generator of nested tables with a controller; None without one.

    Args:
        data: The tables of a case, which may hold mistakes.
        turbine: The file, whose gearbox counts where the case has none.
    """
    control, drivetrain = data.get("control"), data.get("drivetrain")
    kind = control.get("kind") if isinstance(control, Mapping) else None
    if not isinstance(kind, str) or not is_controller(kind):
        return None
    own = drivetrain if isinstance(drivetrain, Mapping) else {}
    assert turbine.nacelle
    values = {"ratio": turbine.nacelle.gear_ratio, "efficiency": 1.0}
    for key in values:
        with suppress(ValueError):
            number = to_si(own[key], "") if key in own else 0.0
            if number > 0.0:
                values[key] = number
    return GeneratorShaft(**values, built_in=kind == "pi")


@dataclass(frozen=True)
class Design:
    """Controller values from a file and the aerodynamics of its rotor.

    Args:
        gap: What the built-in one lacks, one sentence; empty if nothing or for another.
        tables: Tables ``pitch`` and ``drivetrain`` of a case, and ``control`` of the built-in one
            without a gap.
    """

    gap: str
    tables: Mapping[str, Any]


@functools.lru_cache(maxsize=8)
def design_control(turbine: WindIOTurbine, generator: GeneratorShaft) -> Design:
    """The controller of a turbine and what it acts on, without the tables of a case.

    Args:
        generator: What the controller acts on; speeds and torques count on its shaft.
    """
    drives = _make_drives(turbine.control, generator.ratio)
    if not generator.built_in:
        return Design("", drives)
    c = turbine.control
    power = (c and c.rated_power) or turbine.rated_power
    needs = {
        "rated_rotor_speed": c and c.rated_speed,
        "rated_power": power,
        "optimal_tsr": c and c.tip_speed_ratio,
    }
    missing = [key for key, value in needs.items() if not value]
    if missing or c is None or not (c.rated_speed and power and c.tip_speed_ratio):
        return Design(f"it has no control.{missing[0]}", drives)
    N, mechanical, fine = generator.ratio, power / generator.efficiency, c.fine_pitch or 0.0
    try:
        K, gains = _design(turbine, c.rated_speed, mechanical, fine, c.tip_speed_ratio, N)
    except ModelError as error:
        return Design(str(error), drives)
    largest = pi / 2.0 if c.largest_pitch is None else c.largest_pitch
    pitch = {
        "speed": N * c.rated_speed,
        "proportional_gain": gains.proportional,
        "integral_gain": gains.integral,
        "gain_angle": gains.angle,
        "fine": fine,
        "largest": largest,
        "rate": c.pitch_rate or PITCH_RATE,
    }
    control: dict[str, Any] = {"torque": _make_torque_law(c, K, mechanical, N), "pitch": pitch}
    if c.filter_frequency:
        control["filter_frequency"] = c.filter_frequency
    return Design("", {"control": control, **drives})


def _make_drives(c: ControllerData | None, ratio: float) -> dict[str, Any]:
    """The tables ``pitch`` and ``drivetrain``; blades start at the fine pitch."""
    bearings: dict[str, Any] = {"bearings": True, "drive": "actuator"}
    if c is not None:
        found = {
            "initial": c.fine_pitch,
            "frequency": c.drive_frequency,
            "damping_ratio": c.drive_damping,
        }
        bearings.update({key: value for key, value in found.items() if value})
    return {"pitch": bearings, "drivetrain": {"ratio": ratio}}


def _make_torque_law(c: ControllerData, K: float, power: float, N: float) -> dict[str, float]:
    """The table ``control.torque``.

    Args:
        K: Torque over squared speed of the rotor that keeps the tip-speed ratio [N m s^2/rad^2].
        power: Rated mechanical power [W].
        N: Speed of the generator over that of the rotor.
    """
    assert c.rated_speed
    rated = BELOW_RATED * c.rated_speed
    torque, line = power / rated, rated / (1.0 + SLIP)
    least = min(c.least_speed or LEAST_SPEED * c.rated_speed, 0.8 * line)
    return {
        "cut_in_speed": N * least,
        "optimal_speed": N * min(REGION_2 * least, 0.5 * (least + line)),
        "gain": min(K, BELOW_RATED * torque / rated**2) / N**3,
        "rated_speed": N * rated,
        "rated_power": power,
        "slip": SLIP,
        "largest": max(c.largest_torque or 0.0, TORQUE_MARGIN * torque / N),
        "rate": c.torque_rate or torque / (N * TORQUE_TIME),
    }


def _design(
    turbine: WindIOTurbine, speed: float, power: float, fine: float, ratio: float, N: float
) -> tuple[float, Any]:
    """Torque over squared speed of the rotor, and gains of the pitch."""
    from turbine_fenicsx.control.gain_design import (
        RatedPoint,
        find_pitch_gains,
        find_torque_gain,
    )

    rotor, rated = _make_rotor(turbine), RatedPoint(speed, power, fine)
    gains = find_pitch_gains(rotor, rated, find_inertia(turbine), N)
    return find_torque_gain(rotor, rated, ratio), gains


def _make_rotor(turbine: WindIOTurbine) -> Rotor:
    """The rotor with stiff blades, without tilt."""
    from turbine_fenicsx.wind.resampling import place_stations
    from turbine_fenicsx.wind.rotor import Rotor
    from turbine_fenicsx.wind.windio_blade import make_aero_blade

    hub, axis = turbine.hub.radius, turbine.blade.outer_shape.axis[2]
    tip = hub + float(axis.smooth(np.array([1.0]))[0])
    radius, lengths = place_stations(hub, tip, STATIONS)
    blade = replace(make_aero_blade(turbine, radius), lengths=lengths)
    cone = np.radians(turbine.hub.cone_angle)
    return Rotor(blade, turbine.blade_count, cone, hub_height=turbine.hub_height or 2.0 * tip)


def find_inertia(turbine: WindIOTurbine) -> float:
    """Inertia of blades and hub about the shaft, without the generator's [kg m^2]."""
    sections = turbine.blade_sections
    if sections is None:
        raise ModelError("its blade has no elastic_properties with the masses of its sections")
    z = turbine.blade.outer_shape.axis[2].smooth(sections.grid)
    r = (turbine.hub.radius + z) * np.cos(np.radians(turbine.hub.cone_angle))
    f = sections.inertia[:, 0, 0] * r * r
    blade = float(0.5 * (f[1:] + f[:-1]) @ np.diff(z))
    hub = turbine.hub.body
    return turbine.blade_count * blade + (float(hub.inertia[0, 0]) if hub else 0.0)
