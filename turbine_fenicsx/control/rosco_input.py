"""How a turbine is run in steady wind, by the input file of ROSCO (DISCON.IN).

A value, or some numbers, stand before a ``!`` and their key. Speeds are those of the generator.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.keyed_text import KeyedText
from turbine_fenicsx.foundation.types import Array

_KEY = re.compile(r"[^!]*[^!\s][^!]*!\s*(\w+)")

TRACKS_RATIO = (2, 3)
"""Values of VS_ControlMode that keep the tip-speed ratio VS_TSRopt."""

MOST = 10_000
"""Maximum length of a table."""


@dataclass(frozen=True, eq=False)
class RoscoInput:
    """Steady operation by an input file of ROSCO; speeds are those of the rotor.

    Args:
        least_speed: Smallest speed [rad/s].
        rated_speed: Speed that the pitch keeps [rad/s].
        rated_power: Mechanical power of the generator above rated wind [W].
        tip_speed_ratio: The one that is kept, or the best one of the table of performance [-].
        fine_pitch: Pitch below rated power [rad].
        least_pitch: Smallest pitch over the wind speed, which limits the thrust: rows of wind speed
            [m/s] and pitch [rad], shape (n, 2); without rows if nothing limits it.
    """

    least_speed: float
    rated_speed: float
    rated_power: float
    tip_speed_ratio: float
    fine_pitch: float
    least_pitch: Array


def read_rosco_input(path: str | os.PathLike[str]) -> RoscoInput:
    """Read an input file of ROSCO, and where it needs that the table of performance it names.

    Raises:
        InputError: if a file cannot be read, lacks a key, or has numbers that cannot be.
    """
    file = _RoscoText(path)
    ratio, efficiency = file.positive("WE_GearboxRatio"), file.positive("VS_GenEff") / 100.0
    fine = file.number("PC_FinePit")
    if int(file.number("VS_ControlMode")) in TRACKS_RATIO:
        best = file.positive("VS_TSRopt")
    else:
        best = read_best_ratio(file.name("PerfFileName"), fine)
    least = np.zeros((0, 2))
    if file.number("PS_Mode") != 0.0:
        count = int(file.positive("PS_BldPitchMin_N", MOST))
        least = np.column_stack(
            [file.row(key, count) for key in ("PS_WindSpeeds", "PS_BldPitchMin")]
        )
        if np.any(np.diff(least[:, 0]) <= 0.0):
            raise InputError(f"{file.path}: PS_WindSpeeds must rise")
    return RoscoInput(
        least_speed=file.number("VS_MinOMSpd") / ratio,
        rated_speed=file.positive("PC_RefSpd") / ratio,
        rated_power=file.positive("VS_RtPwr") / efficiency,
        tip_speed_ratio=best,
        fine_pitch=fine,
        least_pitch=least,
    )


def read_best_ratio(path: str | os.PathLike[str], pitch: float) -> float:
    """Tip-speed ratio of the largest power coefficient at a pitch, of a Cp_Ct_Cq table of ROSCO.

    Args:
        pitch: Pitch of the blades [rad].

    Raises:
        InputError: if the file cannot be read or is no such table.
    """
    text = KeyedText.read(path, "ROSCO's performance")
    (pitches,) = text.read_table(_find_line(text, "pitch angle vector") + 1, 1, 2)
    (ratios,) = text.read_table(_find_line(text, "tsr vector") + 1, 1, 3)
    C_P = text.read_table(_find_line(text, "power coefficient") + 1, len(ratios), len(pitches))
    for name, values in (("pitch angles", pitches), ("tip-speed ratios", ratios)):
        if np.any(np.diff(values) <= 0.0):
            raise InputError(f"{text.path}: {name} must rise")
    at_pitch = np.array([np.interp(np.degrees(pitch), pitches, row) for row in C_P])
    # a parabola through the largest value and its neighbours
    k = int(np.clip(np.argmax(at_pitch), 1, len(ratios) - 2))
    a, b, _ = np.polyfit(ratios[k - 1 : k + 2], at_pitch[k - 1 : k + 2], 2)
    if a >= 0.0:
        raise InputError(f"{text.path} has no largest power coefficient at {pitch:g} rad")
    return float(np.clip(-0.5 * b / a, ratios[0], ratios[-1]))


def _find_line(text: KeyedText, words: str) -> int:
    """Index of the line with some words; an InputError if there is none."""
    for k, line in enumerate(text.lines):
        if words in line.lower():
            return k
    raise InputError(f"{text.path} is no file of {text.what}: it has no {words}")


class _RoscoText:
    """The lines of an input file by their keys."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._text = KeyedText.read(path, "ROSCO")
        self.path = self._text.path
        matches = ((k, _KEY.match(line)) for k, line in enumerate(self._text.lines))
        self._lines = {match[1].lower(): k for k, match in matches if match}

    def row(self, key: str, count: int) -> Array:
        """The numbers before a key."""
        return np.array(self._text.read_numbers(self._line(key), count))

    def number(self, key: str) -> float:
        """The number before a key."""
        return float(self.row(key, 1)[0])

    def positive(self, key: str, most: float = np.inf) -> float:
        """A number above zero before a key."""
        value = self.number(key)
        if not 0.0 < value <= most:
            limit = "" if most == np.inf else f", at most {most:g}"
            self._text.fail(self._line(key), f"{key} must be positive{limit}, got {value:g}")
        return value

    def name(self, key: str) -> Path:
        """The file before a key, which counts from the folder of this one."""
        value = self._text.lines[self._line(key)].split("!")[0].strip().strip("\"'")
        return Path(self.path).parent / value

    def _line(self, key: str) -> int:
        """Index of the line of a key."""
        if key.lower() not in self._lines:
            raise InputError(f"{self.path} is no input of ROSCO: it has no {key}")
        return self._lines[key.lower()]
