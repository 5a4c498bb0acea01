"""Columns over the time from a file of comma-separated values, with units in its heading."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from turbine_fenicsx.case.quantities import to_si
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote, read_text
from turbine_fenicsx.foundation.types import Array

TIME = "time"
_HEADING = re.compile(r"\s*(\w+?)_?\s*(?:[\[(](.*)[\])])?\s*")


@dataclass(frozen=True)
class Column:
    """Allowed contents of a column.

    Args:
        unit: SI unit, empty for none.
    """

    unit: str
    least: float = -1e30
    most: float = 1e30


@dataclass(frozen=True, eq=False)
class TimeTable:
    """Columns over the time.

    Args:
        times: Rising, shape (n,) [s].
        columns: Values in SI units by their names, each of shape (n,).
    """

    name: str
    times: Array
    columns: Mapping[str, Array]

    def describe_gap(self, end: float) -> str:
        """A sentence if the times do not reach from 0 to the end of a run; else nothing.

        Args:
            end: Of the run [s].
        """
        if self.times[0] <= 0.0 and self.times[-1] >= end:
            return ""
        return (
            f"{self.name} goes from {self.times[0]:g} to {self.times[-1]:g} s, expected times from "
            f"0 to time.end = {end:g} s"
        )


def read_time_table(path: str, columns: Mapping[str, Column]) -> TimeTable:
    """Read a file whose first line names its columns, as in ``time [s], rotor_torque [kN m]``.

    Commas, semicolons or tabs stand between columns; a column without a unit counts in SI. Empty
    lines and those that begin with # do not count. Angles turn the short way from line to line:
    from 350 to 10 degrees by 20.

    Args:
        columns: Those that are known beside ``time``, by their names.

    Returns:
        The table, which has one or more of the known columns.
    """
    name, lines = Path(path).name, _split(read_text(path, "table"))
    if not lines:
        raise InputError(f"{name} is empty, expected a heading and two or more lines of numbers")
    found, factors = _read_heading(name, lines[0][1], columns)
    rows = [_read_row(name, number, fields, len(found), raw) for number, fields, raw in lines[1:]]
    if len(rows) < 2:
        raise InputError(f"{name} has {len(rows)} lines of numbers, expected two or more")
    values = np.array(rows) * factors
    table = dict(zip(found, values.T, strict=True))
    times = table.pop(TIME)
    numbers = [number for number, *_ in lines[1:]]
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        k = int(late[0])
        raise InputError(
            f"{name}, line {numbers[k + 1]}: times must rise, got {times[k + 1]:g} s after "
            f"{times[k]:g} s"
        )
    for key, column in table.items():
        low, high = columns[key].least, columns[key].most
        wrong = np.flatnonzero((column < low) | (column > high))
        if wrong.size:
            k = int(wrong[0])
            raise InputError(
                f"{name}, line {numbers[k]}: {key} = {column[k]:g} {columns[key].unit}".rstrip()
                + f" must lie between {low:g} and {high:g}"
            )
    angles = {key: np.unwrap(x) for key, x in table.items() if columns[key].unit == "rad"}
    return TimeTable(name, times, table | angles)


def _split(text: str) -> list[tuple[int, list[str], str]]:
    """Numbers of the lines that count, their fields, and the lines themselves."""
    lines = [(k, line.strip()) for k, line in enumerate(text.splitlines(), start=1)]
    return [(k, re.split(r"[,;\t]", x), x) for k, x in lines if x and not x.startswith("#")]


def _read_heading(
    name: str, fields: list[str], columns: Mapping[str, Column]
) -> tuple[list[str], Array]:
    """Names of the columns, and factors to SI units."""
    known = {TIME: Column("s"), **columns}
    found: list[str] = []
    factors = []
    for field in fields:
        match = _HEADING.fullmatch(field)
        key, unit = (match[1], match[2]) if match else (field.strip(), None)
        if key not in known or key in found:
            which = "a second" if key in found else "an unknown"
            raise InputError(
                f"{name} has {which} column {quote(key)}, expected {TIME} and one or more of "
                f"{', '.join(columns)}"
            )
        found.append(key)
        factors.append(_find_factor(name, key, unit, known[key].unit))
    if TIME not in found or len(found) < 2:
        lacking = TIME if TIME not in found else f"one of {', '.join(columns)}"
        raise InputError(f"{name} has no column {lacking}; its first line must name the columns")
    return found, np.array(factors)


def _find_factor(name: str, key: str, unit: str | None, expected: str) -> float:
    """Factor from the unit of a heading to that in SI."""
    if unit is None or unit.strip() in ("", "-"):
        return 1.0
    try:
        return to_si(f"1 {unit.replace('Nm', 'N m')}", expected)
    except ValueError as error:
        raise InputError(f"{name}, column {key} [{unit}]: {error}") from None


def _read_row(name: str, number: int, fields: list[str], n: int, raw: str) -> list[float]:
    """The numbers of a line."""
    try:
        row = [float(field) for field in fields]
    except ValueError:
        row = []
    if len(row) != n or not all(math.isfinite(x) for x in row):
        raise InputError(f"{name}, line {number}: expected {n} finite numbers, got {quote(raw)}")
    return row
