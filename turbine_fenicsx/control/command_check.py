"""Check what a controller returns and convert it to `Commands`."""

from __future__ import annotations

import reprlib
from itertools import islice
from typing import Any

import numpy as np

from turbine_fenicsx.control.interface import BLADES, Commands
from turbine_fenicsx.foundation.errors import ForeignError

LARGEST_TORQUE = 1e9
"""Thirty times that of the largest generator without a gearbox [N m]."""

LARGEST_ANGLE = 2.0 * np.pi
"""A pitch beyond one turn is a mistake, such as degrees for radians [rad]."""

LARGEST_RATE = 1.0
"""Yaw drives turn a hundred times slower [rad/s]."""

_LABELS = ("generator torque", "pitch", "yaw rate", "brake")


def check_commands(commands: Any, who: str, time: float) -> Commands:
    """Commands as finite numbers that some turbine could follow.

    Args:
        time: When [s].
    """
    at = f"at t = {time:g} s"
    try:
        # of what has no end a few are enough to see it
        torque, pitch, *rest = islice(commands, len(_LABELS) + 1)
        angles = [float(angle) for angle in islice(pitch, BLADES + 1)]
        numbers = [float(torque), *map(float, rest)]
    except Exception:
        raise ForeignError(
            f"{who} must return Commands(generator_torque, pitch, yaw_rate, brake), got "
            f"{show(commands)} {at}"
        ) from None
    if len(angles) != BLADES or len(rest) > 2:
        raise ForeignError(
            f"{who} must command the pitch of {BLADES} blades, got {show(commands)} {at}"
        )
    found = Commands(numbers[0], (angles[0], angles[1], angles[2]), *numbers[1:])
    values = ([found.generator_torque], found.pitch, [found.yaw_rate], [found.brake])
    wrong = [label for label, v in zip(_LABELS, values, strict=True) if not np.all(np.isfinite(v))]
    if wrong:
        raise ForeignError(f"{who} commands no number as {' and '.join(wrong)} {at}: {found}")
    _check_sizes(found, who, at)
    return found


def _check_sizes(c: Commands, who: str, at: str) -> None:
    """Refuse what no turbine can do."""
    for label, value, least, most, unit in (
        ("a generator torque", c.generator_torque, -LARGEST_TORQUE, LARGEST_TORQUE, " N m"),
        ("a pitch", max(c.pitch, key=abs), -LARGEST_ANGLE, LARGEST_ANGLE, " rad"),
        ("a yaw rate", c.yaw_rate, -LARGEST_RATE, LARGEST_RATE, " rad/s"),
        ("a brake", c.brake, 0.0, 1.0, ""),
    ):
        if not least <= value <= most:
            raise ForeignError(
                f"{who} commands {label} of {value:g}{unit} {at}: expected {least:.4g} to "
                f"{most:.4g}{unit}"
            )


def show(value: Any) -> str:
    """A foreign object in a few letters on one line, whatever its own text does."""
    try:
        text = " ".join(reprlib.repr(value).split())
    except Exception:
        return f"an object of type {type(value).__name__}"
    return text[:200]
