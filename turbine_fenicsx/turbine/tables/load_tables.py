"""Torques and pitch over the time from files: what they hold, and what else a case may say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import degrees, pi
from pathlib import Path

from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.case.section import HUGE
from turbine_fenicsx.case.time_table import (
    Column,
    TimeTable,
    read_time_table,
)
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.tables import Tables

TORQUES = ("rotor_torque", "yaw_torque", "pitch_torque")
"""Keys of the loads, and columns of their file."""

BLADES = ("pitch_1", "pitch_2", "pitch_3")
"""Columns for each blade by itself, in place of one for all."""

MAX_ANGLE = 2.0 * pi
"""Pitch [rad]."""

TIME_TOLERANCE = 1e-6
"""Pitch at t = 0 and that at which the blades start agree so well [rad]."""

_TORQUE = {name: Column("N m", -HUGE, HUGE) for name in TORQUES}
_PITCH = {name: Column("rad", -MAX_ANGLE, MAX_ANGLE) for name in ("pitch", *BLADES)}


@read_if_changed("table")
def load_torques(path: str) -> TimeTable:
    """Torques of a file; raises InputError."""
    return read_time_table(path, _TORQUE)


@read_if_changed("table")
def _load_pitch(path: str) -> TimeTable:
    """Pitch of a file; raises InputError."""
    return read_time_table(path, _PITCH)


def load_pitch(path: str) -> list[tuple[TimeTable, str]]:
    """The table with the pitch of each blade, and its column.

    Raises:
        InputError: if it cannot be read, or does not have the pitch of all blades once.
    """
    table = _load_pitch(path)
    found = set(table.columns)
    if found == {"pitch"}:
        return [(table, "pitch")] * len(BLADES)
    if found == set(BLADES):
        return [(table, name) for name in BLADES]
    raise InputError(
        f"{table.name} has the columns {', '.join(table.columns)}, expected pitch, or "
        f"{', '.join(BLADES[:-1])} and {BLADES[-1]}"
    )


def _check_torques(case: Tables) -> str:
    """The torques can be read, last as long as the run, and act on what can turn."""
    loads = case.loads
    if loads.file is None:
        return ""
    try:
        table = load_torques(loads.file)
    except InputError as error:
        return f"loads.file: {error}"
    for name in table.columns:
        if getattr(loads, name):
            return (
                f"loads.{name} = {getattr(loads, name):g}: expected none beside loads.file = "
                f"{quote(Path(loads.file).name)}, which has a column of it"
            )
    gap = table.describe_gap(case.time.end)
    return f"loads.file: {gap}" if gap else _check_bearings(case, table.columns)


def _check_bearings(case: Tables, columns: Mapping[str, object]) -> str:
    """Torques act on bearings that no drive turns."""
    free = ("free", "spring")
    reason = ""
    if "yaw_torque" in columns and case.yaw.drive != "free":
        reason = f'yaw_torque: expected yaw.drive = "free", got "{case.yaw.drive}"'
    if "pitch_torque" in columns and not case.has_pitch_bearings:
        reason = "pitch_torque: expected pitch.bearings = true"
    elif "pitch_torque" in columns and case.pitch.drive not in free:
        reason = (
            f'pitch_torque: expected pitch.drive = "free" or "spring", got "{case.pitch.drive}"'
        )
    return f"loads.file has a column {reason}" if reason else ""


def _check_pitch(case: Tables) -> str:
    """The pitch can be read, lasts as long as the run, and begins where the blades start."""
    pitch = case.pitch
    if pitch.file is None or pitch.drive != "prescribed" or not case.has_pitch_bearings:
        return ""
    try:
        blades = load_pitch(pitch.file)
    except InputError as error:
        return f"pitch.file: {error}"
    gap = blades[0][0].describe_gap(case.time.end)
    if gap:
        return f"pitch.file: {gap}"
    from turbine_fenicsx.forces.time_functions import Table  # not needed to read other cases

    for table, name in blades:
        first = Table(table.times.tolist(), table.columns[name].tolist())(0.0)
        if abs(first - pitch.initial) > TIME_TOLERANCE:
            return (
                f"pitch.initial = {degrees(pitch.initial):g} deg: expected {degrees(first):g} deg, "
                f"the value of {name} at t = 0 in pitch.file"
            )
    return ""


TABLE_CHECKS: tuple[tuple[tuple[str, ...], Callable[[Tables], str]], ...] = (
    (("loads", "time.end", "pitch", "yaw", "turbine.model"), _check_torques),
    (("pitch", "time.end", "turbine.model"), _check_pitch),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""
