"""The table of gravity and torques, and the file of torques over the time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile, read_if_changed
from turbine_fenicsx.case.quantities import Acceleration, Seconds, Torque
from turbine_fenicsx.case.rules import AnyOf, Only, Unless
from turbine_fenicsx.case.section import HUGE, Finite, NotNegative, Positive, Section
from turbine_fenicsx.case.time_table import Column, TimeTable, read_time_table
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.pitch import HAS_BEARINGS

TORQUES = ("rotor_torque", "yaw_torque", "pitch_torque")
"""Keys of the loads, and columns of their file."""

HAS_TORQUE = tuple(Unless(f"loads.{name}", 0.0) for name in TORQUES)
"""Rules of keys that count with a torque only."""

_COLUMNS = {name: Column("N m", -HUGE, HUGE) for name in TORQUES}


@read_if_changed("table")
def load_torques(path: str) -> TimeTable:
    """Torques of a file; raises InputError."""
    return read_time_table(path, _COLUMNS)


class LoadsCase(Section):
    """Gravity, and torques on rotor, yaw and pitch bearings.

    Torques are hat functions of time, eq. (60), or columns of the same names in a ``file`` of
    comma-separated values.
    """

    gravity: Annotated[Acceleration, NotNegative] = 9.81
    """Acceleration, downwards."""
    file: Annotated[str | None, DataFile("loads file")] = None
    """CSV file with ``time`` and one or more of ``rotor_torque``, ``yaw_torque``,
    ``pitch_torque``, relative to the case file, see howto/tables."""
    rotor_torque: Annotated[Torque, Finite] = 0.0
    """Peak of the torque on the rotor bearing, positive about e₃."""
    yaw_torque: Annotated[Torque, Finite, Only("yaw.drive", "free")] = 0.0
    """Peak of the torque on the yaw bearing, negative about e₂."""
    pitch_torque: Annotated[
        Torque, Finite, HAS_BEARINGS, Unless("pitch.drive", "prescribed", "actuator")
    ] = 0.0
    """Peak of the torque on each pitch bearing, positive to feather."""
    duration: Annotated[Seconds, Positive, AnyOf(*HAS_TORQUE, say="without a torque")] = 3.0
    """Duration of all hat functions, which begin at t = 0."""

    @check("file", "", "time.end", "pitch", "yaw", "turbine.model")
    def _check_file(self, case: Any) -> str:
        """The torques can be read, last as long as the run, and act on what can turn."""
        if self.file is None:
            return ""
        try:
            table = load_torques(self.file)
        except InputError as error:
            return f"loads.file: {error}"
        for name in table.columns:
            if getattr(self, name):
                return (
                    f"loads.{name} = {getattr(self, name):g}: expected none beside loads.file = "
                    f"{quote(Path(self.file).name)}, which has a column of it"
                )
        gap = table.describe_gap(case.time.end)
        return f"loads.file: {gap}" if gap else _check_bearings(case, table.columns)


def _check_bearings(case: Any, columns: Mapping[str, object]) -> str:
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
