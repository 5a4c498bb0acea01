"""Wind over the time from a file: a separate table, or OpenFAST's uniform wind."""

from __future__ import annotations

from math import pi
from pathlib import Path

from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.case.time_table import (
    Column,
    TimeTable,
    read_time_table,
)
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.wind.tabulated_wind import RANGES, read_uniform_wind

MAX_INCLINATION = pi / 3.0
"""Largest angle between wind and ground [rad]."""

FALLBACKS = ("shear", "direction", "inclination")
"""Keys of the wind that a table may have as columns."""

COLUMNS = {
    "speed": Column("m/s", *RANGES["speed"]),
    "direction": Column("rad", -7.0, 7.0),
    "inclination": Column("rad", -MAX_INCLINATION, MAX_INCLINATION),
    "shear": Column("", *RANGES["shear"]),
    "vertical_speed": Column("m/s", *RANGES["vertical_speed"]),
    "horizontal_shear": Column("", *RANGES["horizontal_shear"]),
    "vertical_shear": Column("", *RANGES["vertical_shear"]),
    "gust": Column("m/s", *RANGES["gust"]),
}
"""Columns of a table of comma-separated values."""


@read_if_changed("table")
def load_wind_table(path: str) -> TimeTable:
    """The wind of a file of either format; raises InputError."""
    if Path(path).suffix.lower() != ".csv":
        times, columns = read_uniform_wind(path)
        return TimeTable(Path(path).name, times, columns)
    table = read_time_table(path, COLUMNS)
    if "speed" not in table.columns:
        raise InputError(f"{table.name} has no column speed, the wind at the height of the hub")
    return table


def check_wind_table(path: str, end: float) -> str:
    """A sentence if the wind of a file cannot be that of a run; else nothing.

    Args:
        path: The file.
        end: End of the run [s].
    """
    try:
        gap = load_wind_table(path).describe_gap(end)
    except InputError as error:
        return f"wind.file: {error}"
    return f"wind.file: {gap}" if gap else ""


def describe_wind_table(path: str) -> str:
    """Kind of wind of a file, in a few words."""
    table = load_wind_table(path)
    speed = table.columns["speed"]
    return (
        f"wind of {quote(table.name)}, {speed.min():g} to {speed.max():g} m/s in {len(speed)} "
        f"lines from {table.times[0]:g} to {table.times[-1]:g} s"
    )
