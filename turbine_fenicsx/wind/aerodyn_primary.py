"""A blade by the primary file of AeroDyn 15, which names the files of blade and polars."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.aerodyn_files import (
    PolarColumns,
    read_aerodyn_blade,
    read_aerodyn_polar,
)
from turbine_fenicsx.wind.aerodyn_text import AeroDynText

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

    Raises:
        InputError: if it, or a file that it names, is none of AeroDyn 15, or blades differ.
        FileError: if one cannot be read.
    """
    text = AeroDynText.read(path)
    count, first = text.find_count("NumAFfiles")
    if count > MAX_POLARS:
        raise InputError(f"{os.fspath(path)} names {count} polars, at most {MAX_POLARS} are read")
    names = [_read_name(text, first + k) for k in range(count)]
    row = next((k for k, line in enumerate(text.lines) if "ADBlFile(1)" in line), None)
    if row is None:
        raise InputError(f"{os.fspath(path)} names no blade: it has no ADBlFile(1)")
    folder = Path(path).parent
    columns, first_alone = _read_columns(text), _read_interpolation(text)
    polars = [read_aerodyn_polar(folder / name, columns, first_alone) for name in names]
    blade = read_aerodyn_blade(folder / _read_name(text, row), hub_radius, polars)
    others = [k for k, line in enumerate(text.lines) if re.search(r"ADBlFile\([2-9]\)", line)]
    for k in others[:2]:
        _check_same(text, folder, row, k)
    if read_setting(text, "UseBlCm") == "false":
        found = {id(p): replace(p, moment=0.0 * p.moment) for p in polars}
        return replace(blade, polars=tuple(found[id(p)] for p in blade.polars))
    return blade


def read_setting(text: AeroDynText, key: str) -> str | None:
    """The value of a key in small letters, flags as true and false; None without it."""
    found = text.find(key)
    value = found[0].lower() if found else None
    return {"t": "true", ".true.": "true", "f": "false", ".false.": "false"}.get(value or "", value)


def _read_columns(text: AeroDynText) -> PolarColumns:
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


def _read_interpolation(text: AeroDynText) -> bool:
    """Whether polars may have tables that are not used, those after the first."""
    found = text.find("AFTabMod")
    if found and found[0].lower() not in ("1", "2", "3", "default"):
        text.fail(found[1], f"AFTabMod must be 1, 2 or 3, got {found[0][:40]!r}")
    return found is None or found[0].lower() in ("1", "default")


def _check_same(text: AeroDynText, folder: Path, first: int, other: int) -> None:
    """All blades of a rotor are the first one."""
    names = [_read_name(text, k) for k in (first, other)]
    if names[0] == names[1] or names[1].lower() in ("unused", "none", ""):
        return
    one, two = (AeroDynText.read(folder / name) for name in names)
    if one.lines != two.lines:
        text.fail(
            other,
            f"blade {quote(names[1])} differs from {quote(names[0])}, expected equal blades",
        )


def _read_name(text: AeroDynText, row: int) -> str:
    """The name of a file at the beginning of a line, with or without quotes."""
    line = text.lines[row].strip() if row < len(text.lines) else ""
    match = re.match(r"\"([^\"]+)\"|'([^']+)'|(\S+)", line)
    if match is None:
        text.fail(row, f"expected the name of a file, got {quote(line)}")
    name = match[1] or match[2] or match[3]
    return name.replace("\\", "/")
