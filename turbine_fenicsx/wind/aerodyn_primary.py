"""A blade by the primary file of AeroDyn 15, which names the files of blade and polars."""

from __future__ import annotations

import os
import re
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.aerodyn_files import (
    find_count,
    read_aerodyn_blade,
    read_aerodyn_polar,
    read_lines,
)

MOST_POLARS = 1000
"""More polars than that are a slip."""


def read_aerodyn(path: str | os.PathLike[str], hub_radius: float) -> AeroBlade:
    """The first blade of a primary file of AeroDyn 15, with its polars.

    Args:
        path: The file; others are found from its folder on.
        hub_radius: Where the blade begins [m].

    Raises:
        InputError: if it, or a file that it names, is none of AeroDyn 15.
        FileError: if one cannot be read.
    """
    lines = read_lines(path)
    count, first = find_count(path, lines, "NumAFfiles")
    if count > MOST_POLARS:
        raise InputError(f"{os.fspath(path)} names {count} polars, at most {MOST_POLARS} are read")
    names = [_read_name(path, lines, first + k) for k in range(count)]
    row = next((k for k, line in enumerate(lines) if "ADBlFile(1)" in line), None)
    if row is None:
        raise InputError(f"{os.fspath(path)} names no blade: it has no ADBlFile(1)")
    folder = Path(path).parent
    polars = [read_aerodyn_polar(folder / name) for name in names]
    return read_aerodyn_blade(folder / _read_name(path, lines, row), hub_radius, polars)


def _read_name(path: str | os.PathLike[str], lines: list[str], row: int) -> str:
    """The name of a file at the beginning of a line, with or without quotes."""
    text = lines[row].strip() if row < len(lines) else ""
    match = re.match(r"\"([^\"]+)\"|'([^']+)'|(\S+)", text)
    if match is None:
        raise InputError(
            f"{os.fspath(path)}, line {row + 1}: expected the name of a file, got {quote(text)}"
        )
    name = match[1] or match[2] or match[3]
    return name.replace("\\", "/")
