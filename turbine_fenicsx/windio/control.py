"""The controller of a windIO file: speeds, limits and rates, in SI units."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from turbine_fenicsx.windio.entry import Entry

RPM, DEGREE = pi / 30.0, pi / 180.0


@dataclass(frozen=True)
class ControllerData:
    """Values of the section ``control``; None for missing ones. Speeds are the rotor's.

    Args:
        least_speed: Smallest speed [rad/s].
        rated_speed: Rated speed [rad/s].
        rated_power: Rated electrical power [W].
        tip_speed_ratio: The best one below rated speed [-].
        largest_torque: Largest torque of the generator [N m].
        torque_rate: Its largest rate [N m/s].
        fine_pitch: Pitch below rated speed [rad].
        largest_pitch: Largest pitch [rad].
        pitch_rate: Its largest rate [rad/s].
        filter_frequency: Corner of the filter of the speed [rad/s].
        drive_frequency: Natural frequency of the pitch drives [rad/s].
        drive_damping: Damping ratio of the pitch drives [-].
    """

    least_speed: float | None
    rated_speed: float | None
    rated_power: float | None
    tip_speed_ratio: float | None
    largest_torque: float | None
    torque_rate: float | None
    fine_pitch: float | None
    largest_pitch: float | None
    pitch_rate: float | None
    filter_frequency: float | None
    drive_frequency: float | None
    drive_damping: float | None


_KEYS = {
    "least_speed": ("min_rotor_speed", RPM),
    "rated_speed": ("rated_rotor_speed", RPM),
    "rated_power": ("rated_power", 1.0),
    "tip_speed_ratio": ("optimal_tsr", 1.0),
    "largest_torque": ("max_gen_torque", 1.0),
    "torque_rate": ("max_torque_rate", 1.0),
    "fine_pitch": ("fine_pitch", DEGREE),
    "largest_pitch": ("max_pitch_limit", DEGREE),
    "pitch_rate": ("max_pitch_rate", DEGREE),
    "filter_frequency": ("lpf_frequency", 1.0),
    "drive_frequency": ("pitch_actuator_frequency", 1.0),
    "drive_damping": ("pitch_actuator_damping", 1.0),
}
"""Keys of windIO, and factors to SI units."""

_ANGLES = ("fine_pitch", "largest_pitch")


def read_control(entry: Entry) -> ControllerData:
    """The section `control`."""
    found: dict[str, float | None] = {}
    for name, (key, factor) in _KEYS.items():
        least = -90.0 if name in _ANGLES else 0.0
        found[name] = factor * entry[key].number(least) if key in entry else None
    return ControllerData(**found)
