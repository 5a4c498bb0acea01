"""Speeds of the rotor on the command line: ``12 rpm``, ``0:14:2 rpm``."""

from __future__ import annotations

import re
from math import isfinite, pi

from turbine_fenicsx.foundation.errors import InputError

MOST = 200
"""Largest number of speeds of one range."""

UNITS = {"rpm": pi / 30.0, "rad/s": 1.0, "deg/s": pi / 180.0}
"""Units of a speed in rad/s."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_SPEED = re.compile(rf"({_NUMBER})\s*({'|'.join(UNITS)})", re.ASCII)
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER}):({_NUMBER})\s*({'|'.join(UNITS)})", re.ASCII)


def parse_speed(words: list[str]) -> float:
    """The speed of ``--speed`` [rad/s].

    Raises:
        InputError: for what is no number with a unit.
    """
    text = " ".join(words)
    match = _SPEED.fullmatch(text.strip())
    if match is None:
        raise InputError(
            f'--speed {text}: give a number and rpm, rad/s or deg/s, for example "12 rpm"'
        )
    return float(match[1]) * UNITS[match[2]]


def parse_speeds(words: list[str]) -> tuple[float, ...]:
    """The speeds of ``--speeds`` from the first to the last [rad/s].

    Raises:
        InputError: for what is no range with a unit, or one without end.
    """
    text = " ".join(words)
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(
            f"--speeds {text}: give START:END:STEP and rpm, rad/s or deg/s, for example 0:14:2 rpm"
        )
    start, end, step = (float(match[k]) for k in (1, 2, 3))
    if not all(isfinite(x) for x in (start, end, step)) or step <= 0.0 or end <= start:
        raise InputError(f"--speeds {text}: the end must be above the start, the step above 0")
    number = int((end - start) / step * (1.0 + 1e-9)) + 1
    if not 2 <= number <= MOST:
        raise InputError(
            f"--speeds {text}: these are {number} speeds, from 2 to {MOST} are allowed"
        )
    return tuple((start + k * step) * UNITS[match[4]] for k in range(number))
