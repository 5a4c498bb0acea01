"""A blade by the primary file of AeroDyn 15, which names the files of blade and polars."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
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

    text: AeroDynText
    polars: list[Path]
    blade: Path
    others: list[tuple[int, Path]]

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> AeroDynNames:
        """The names in a file."""
        text, folder = AeroDynText.read(path), Path(path).parent
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


def _check_same(text: AeroDynText, first: Path, line: int, other: Path) -> None:
    """All blades of a rotor are the first one."""
    if first == other or other.name.lower() in ("unused", "none", ""):
        return
    if AeroDynText.read(first).lines != AeroDynText.read(other).lines:
        text.fail(
            line,
            f"blade {quote(other.name)} differs from {quote(first.name)}, expected equal blades",
        )


def _read_name(text: AeroDynText, row: int) -> str:
    """The name of a file at the beginning of a line, with or without quotes."""
    line = text.lines[row].strip() if row < len(text.lines) else ""
    match = re.match(r"\"([^\"]+)\"|'([^']+)'|(\S+)", line)
    if match is None:
        text.fail(row, f"expected the name of a file, got {quote(line)}")
    name = match[1] or match[2] or match[3]
    return name.replace("\\", "/")
