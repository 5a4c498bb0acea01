"""Files of AeroDyn 15: polars, blades, and the primary file that names them."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.keyed_text import KeyedText
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.wind.aero_blade import STATION_TOLERANCE, STEEPEST, AeroBlade
from turbine_fenicsx.wind.polar import Polar

BLADE_COLUMNS = {"BlSpn": 0, "BlCrvAC": 1, "BlSwpAC": 2, "BlTwist": 4, "BlChord": 5, "BlAFID": 6}
"""Columns that are read of a blade, and where they are without names above them."""

CENTRE = 0.25
"""Aerodynamic centre of all sections, as a fraction of the chord."""


class PolarColumns(NamedTuple):
    """Columns of a polar's table, counted from 1, under AeroDyn's names without `InCol_`.

    Attributes:
        Cm: Moment; 0 for none, None for the fourth column where there is one.
    """

    Alfa: int = 1
    Cl: int = 2
    Cd: int = 3
    Cm: int | None = None


COLUMNS = PolarColumns()
"""Columns of AeroDyn's examples."""


def read_aerodyn_polar(
    path: str | os.PathLike[str], columns: PolarColumns = COLUMNS, first_alone: bool = True
) -> Polar:
    """The first table of a file with the coefficients of an aerofoil.

    Args:
        path: A file of AeroDyn 15.
        columns: Where the coefficients are.
        first_alone: Whether tables after the first have no effect; else a file has one table.

    Raises:
        InputError: if it is none, its table does not close the circle, or there are more tables.
        FileError: if it cannot be read.
    """
    text = KeyedText.read(path)
    count, first = text.find_count("NumAlf")
    number = text.find("NumTabs")
    if not first_alone and number and number[0] not in ("1", "01"):
        text.fail(
            number[1],
            f"it has {number[0]} tables, between which AFTabMod = 2 or 3 interpolates, which is "
            "not done here: leave the table of rated operation, or set AFTabMod = 1 for the first",
        )
    least = max(c or 0 for c in columns)
    table = text.read_table(first, count, least)
    moment = columns.Cm if columns.Cm is not None else 4 * (table.shape[1] >= 4)
    angle, lift, drag = (table[:, c - 1] for c in columns[:3])
    C_m = table[:, moment - 1] if moment else np.zeros(count)
    try:
        return Polar(Path(path).stem, np.radians(angle), lift, drag, C_m)
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def read_aerodyn_blade(
    path: str | os.PathLike[str], hub_radius: float, polars: Sequence[Polar]
) -> AeroBlade:
    """A blade with chord, twist and polars along its span.

    Columns are found by the names above them. Aerodynamic centres lie where the file has them: at
    a fraction of the chord that is left of the point in which it crosses the plane of span and
    rotor axis.

    Args:
        path: A blade file of AeroDyn 15.
        hub_radius: Where the blade begins [m].
        polars: Those the column BlAFID counts from 1.

    Raises:
        InputError: if the file is none, or names a polar that is not given.
        FileError: if it cannot be read.
    """
    text = KeyedText.read(path)
    count, first = text.find_count("NumBlNds")
    places = _find_columns(text, first)
    table = text.read_table(first, count, max(places.values()) + 1)
    span, prebend, sweep, twist, chord, numbers = (table[:, places[name]] for name in BLADE_COLUMNS)
    strangers = sorted({float(n) for n in numbers if n not in range(1, len(polars) + 1)})
    if strangers:
        raise InputError(
            f"{os.fspath(path)} names polar {strangers[0]:g} in column BlAFID, but {len(polars)} "
            "polars are given"
        )
    radius = hub_radius + span
    tip = float(radius[-1])
    radius = np.clip(radius, hub_radius + STATION_TOLERANCE, tip - STATION_TOLERANCE)
    theta = np.radians(twist)
    if np.any((np.abs(theta) > STEEPEST) & (sweep != 0.0)):
        raise InputError(
            f"{os.fspath(path)}: twist must be below {np.degrees(STEEPEST):g} degrees where "
            "BlSwpAC is not zero"
        )
    way = np.divide(-sweep, np.cos(theta), out=np.zeros_like(sweep), where=sweep != 0.0)
    try:
        return AeroBlade(
            hub_radius,
            tip,
            radius,
            chord,
            theta,
            tuple(polars[int(n) - 1] for n in numbers),
            prebend=prebend + way * np.sin(theta),
            reference=CENTRE + way / np.maximum(chord, 1e-9),
            aerodynamic_centre=CENTRE,
        )
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def _find_columns(text: KeyedText, first: int) -> dict[str, int]:
    """Indices of the columns of a blade, by their names where there are any."""
    names = text.lines[first].replace(",", " ").lower().split() if first < len(text.lines) else []
    if "blspn" not in names:
        return BLADE_COLUMNS
    missing = [name for name in BLADE_COLUMNS if name.lower() not in names]
    if missing:
        text.fail(first, f"the table of the blade has no column {missing[0]}")
    return {name: names.index(name.lower()) for name in BLADE_COLUMNS}


MAX_POLARS = 1000
"""Maximum number of polars."""

MAX_COLUMNS = 100
"""Maximum number of columns of a polar."""


def read_aerodyn(path: str | os.PathLike[str], hub_radius: float) -> AeroBlade:
    """The first blade of a primary file of AeroDyn 15, with its polars.

    Columns of the polars (``InCol_``), ``AFTabMod`` and ``UseBlCm`` are followed.

    Args:
        path: The file; others are found from its folder on.
        hub_radius: Where the blade begins [m].
    """
    names = AeroDynNames.read(path)
    text = names.text
    columns, first_alone = _read_columns(text), _read_interpolation(text)
    polars = [read_aerodyn_polar(polar, columns, first_alone) for polar in names.polars]
    blade = read_aerodyn_blade(names.blade, hub_radius, polars)
    for line, other in names.others[:2]:
        _check_same(text, names.blade, line, other)
    if read_setting(text, "UseBlCm") == "false":
        found = {id(p): replace(p, moment=0.0 * p.moment) for p in polars}
        return replace(blade, polars=tuple(found[id(p)] for p in blade.polars))
    return blade


@dataclass(frozen=True)
class AeroDynNames:
    """Files that a primary file of AeroDyn 15 names.

    Args:
        others: Line and file of each other blade.
    """

    text: KeyedText
    polars: list[Path]
    blade: Path
    others: list[tuple[int, Path]]

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> AeroDynNames:
        """The names in a file."""
        text, folder = KeyedText.read(path), Path(path).parent
        count, first = text.find_count("NumAFfiles")
        if count > MAX_POLARS:
            raise InputError(
                f"{os.fspath(path)} names {count} polars, at most {MAX_POLARS} are read"
            )
        polars = [folder / _read_name(text, first + k) for k in range(count)]
        row = next((k for k, line in enumerate(text.lines) if "ADBlFile(1)" in line), None)
        if row is None:
            raise InputError(f"{os.fspath(path)} names no blade: it has no ADBlFile(1)")
        others = [k for k, line in enumerate(text.lines) if re.search(r"ADBlFile\([2-9]\)", line)]
        return cls(
            text,
            polars,
            folder / _read_name(text, row),
            [(k, folder / _read_name(text, k)) for k in others],
        )

    def list_paths(self) -> list[str]:
        """The files that exist."""
        paths = [*self.polars, self.blade, *(path for _, path in self.others)]
        return [str(path) for path in dict.fromkeys(paths) if path.exists()]


def read_setting(text: KeyedText, key: str) -> str | None:
    """The value of a key in small letters, flags as true and false; None without it."""
    found = text.find(key)
    value = found[0].lower() if found else None
    return {"t": "true", ".true.": "true", "f": "false", ".false.": "false"}.get(value or "", value)


def _read_columns(text: KeyedText) -> PolarColumns:
    """Columns of the polars, those of AeroDyn's examples where the file does not say."""
    given: dict[str, int] = {}
    for name in PolarColumns._fields:
        found = text.find(f"InCol_{name}")
        if found is None:
            continue
        value, line = found
        least = 0 if name == "Cm" else 1
        if not (value.isdecimal() and len(value) < 4 and least <= int(value) <= MAX_COLUMNS):
            text.fail(
                line,
                f"InCol_{name} must be a number of a column from {least} to {MAX_COLUMNS}, got "
                f"{value[:40]!r}",
            )
        given[name] = int(value)
    return PolarColumns(**given)


def _read_interpolation(text: KeyedText) -> bool:
    """Whether polars may have tables that are not used, those after the first."""
    found = text.find("AFTabMod")
    if found and found[0].lower() not in ("1", "2", "3", "default"):
        text.fail(found[1], f"AFTabMod must be 1, 2 or 3, got {found[0][:40]!r}")
    return found is None or found[0].lower() in ("1", "default")


def _check_same(text: KeyedText, first: Path, line: int, other: Path) -> None:
    """All blades of a rotor are the first one."""
    if first == other or other.name.lower() in ("unused", "none", ""):
        return
    if KeyedText.read(first).lines != KeyedText.read(other).lines:
        text.fail(
            line,
            f"blade {quote(other.name)} differs from {quote(first.name)}, expected equal blades",
        )


def _read_name(text: KeyedText, row: int) -> str:
    """The name of a file at the beginning of a line, with or without quotes."""
    line = text.lines[row].strip() if row < len(text.lines) else ""
    match = re.match(r"\"([^\"]+)\"|'([^']+)'|(\S+)", line)
    if match is None:
        text.fail(row, f"expected the name of a file, got {quote(line)}")
    name = match[1] or match[2] or match[3]
    return name.replace("\\", "/")
