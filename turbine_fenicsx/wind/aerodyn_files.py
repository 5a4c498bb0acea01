"""Polars and blades in the files of AeroDyn 15."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aero_blade import INSIDE, AeroBlade
from turbine_fenicsx.wind.polar import Polar

LARGEST = 10_000_000
"""Larger files are no tables of aerofoils or blades [bytes]."""


def read_aerodyn_polar(path: str | os.PathLike[str]) -> Polar:
    """The first table of a file with the coefficients of an aerofoil.

    Args:
        path: A file of AeroDyn 15.

    Raises:
        InputError: if it is none, or its table does not close the circle.
        FileError: if it cannot be read.
    """
    lines = read_lines(path)
    count, first = find_count(path, lines, "NumAlf")
    rows = [line for line in lines[first:] if not line.lstrip().startswith("!")][:count]
    table = _parse_rows(path, rows, count, 3)
    if table.shape[1] == 3:
        table = np.column_stack([table, np.zeros(count)])
    angle, lift, drag, moment = table[:, :4].T
    try:
        return Polar(Path(path).stem, np.radians(angle), lift, drag, moment)
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def read_aerodyn_blade(
    path: str | os.PathLike[str], hub_radius: float, polars: Sequence[Polar]
) -> AeroBlade:
    """A blade with chord, twist and polars along its span.

    Args:
        path: A blade file of AeroDyn 15.
        hub_radius: Where the blade begins [m].
        polars: Those the column BlAFID counts from 1.

    Raises:
        InputError: if the file is none, or names a polar that is not given.
        FileError: if it cannot be read.
    """
    lines = read_lines(path)
    count, first = find_count(path, lines, "NumBlNds")
    table = _parse_rows(path, lines[first + 2 :][:count], count, 7)
    span, prebend, twist, chord = table[:, 0], table[:, 1], table[:, 4], table[:, 5]
    numbers = table[:, 6]
    strangers = sorted({float(n) for n in numbers if n not in range(1, len(polars) + 1)})
    if strangers:
        raise InputError(
            f"{os.fspath(path)} names polar {strangers[0]:g} in column BlAFID, but {len(polars)} "
            "polars are given"
        )
    radius = hub_radius + span
    tip = float(radius[-1])
    radius = np.clip(radius, hub_radius + INSIDE, tip - INSIDE)
    try:
        return AeroBlade(
            hub_radius,
            tip,
            radius,
            chord,
            np.radians(twist),
            tuple(polars[int(n) - 1] for n in numbers),
            prebend=prebend,
        )
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def read_lines(path: str | os.PathLike[str]) -> list[str]:
    """Lines of a text file of sensible size."""
    with name_file_in_errors("read", path), open_regular(path) as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise InputError(f"{os.fspath(path)} is larger than {LARGEST // 1_000_000} MB, so no table")
    return content.decode("utf-8", errors="replace").splitlines()


def find_count(path: str | os.PathLike[str], lines: list[str], word: str) -> tuple[int, int]:
    """The number in front of a word, and the index of the line after it."""
    for k, line in enumerate(lines):
        parts = line.split()
        if len(parts) >= 2 and parts[1] == word:
            text = parts[0]
            digits = text.isdecimal() and len(text) < 10
            if not digits or not 0 < int(text) <= len(lines):
                raise InputError(
                    f"{os.fspath(path)}, line {k + 1}: {word} must be a number of rows that the "
                    f"file has, got {text[:40]!r}"
                )
            return int(text), k + 1
    raise InputError(f"{os.fspath(path)} is no file of AeroDyn 15: it has no {word}")


def _parse_rows(path: str | os.PathLike[str], rows: list[str], count: int, least: int) -> Array:
    """Numbers of a table with at least so many columns."""
    try:
        table = np.array([[float(word) for word in row.split()] for row in rows])
    except ValueError as error:
        raise InputError(f"{os.fspath(path)}: a row of its table is wrong: {error}") from None
    if table.ndim != 2 or len(table) != count or table.shape[1] < least:
        raise InputError(f"{os.fspath(path)} must have {count} rows of at least {least} numbers")
    if not np.all(np.isfinite(table)):
        raise InputError(f"{os.fspath(path)} has numbers that are not finite")
    return table
