"""Tables of a load set, read back from its folder or from files of the same form."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import read_text
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.output_folder import (
    EXTRAPOLATED,
    FATIGUE,
    SET,
    SET_RUNS,
    WINDS,
    need_folder,
)
from turbine_fenicsx.records.steady_tables import WIND

Rows = list[dict[str, str]]


@dataclass(frozen=True, eq=False)
class WindTable:
    """A channel over the wind speed, arrays of shape (speeds,); not-a-number where it is not known.

    Args:
        least: Means of the least values of the runs.
        largest: Of their largest ones.
    """

    speeds: Array
    mean: Array
    deviation: Array
    least: Array
    largest: Array


@dataclass(frozen=True, eq=False)
class StoredSet:
    """The tables of a load set; those that are missing are empty.

    Args:
        winds: Channels over the wind speed by situation and name.
    """

    folder: Path
    runs: Rows
    extremes: Rows
    fatigue: Rows
    returns: Rows
    winds: dict[str, dict[str, WindTable]]

    @staticmethod
    def read(folder: str | os.PathLike[str]) -> StoredSet:
        """Read the tables.

        Raises:
            InputError: for a folder that holds no load set, or tables that are damaged.
        """
        folder = need_folder(folder)
        runs, extremes, fatigue, returns = (
            read_rows(folder / name, needed, name != SET_RUNS) for name, needed in _NEEDED.items()
        )
        winds = read_winds(folder / WINDS, missing=True)
        return StoredSet(folder, runs, extremes, fatigue, returns, winds)


_NEEDED = {
    SET_RUNS: ("run", "situation", WIND, "state", "reason"),
    SET: ("situation", "column", "factored_least", "factored_largest"),
    FATIGUE: ("run", "column", "slope", "equivalent_range"),
    EXTRAPOLATED: ("situation", "column", "side", "return_period_[years]", "value"),
}
"""Columns of tables without which they are none."""


def read_rows(path: Path, needed: Sequence[str], missing: bool = False) -> Rows:
    """Rows of a table.

    Args:
        needed: Columns that it has.
        missing: Whether a file that is missing has no rows.

    Raises:
        InputError: for a file that is missing or has other columns.
    """
    if missing and not path.exists():
        return []
    lines = read_text(path, "table of a load set").splitlines()
    table = csv.DictReader(line for line in lines if not line.startswith("#"))
    lacking = [column for column in needed if column not in (table.fieldnames or ())]
    if lacking:
        raise InputError(f"the table {str(path)!r} has no column {lacking[0]!r}")
    try:
        rows = list(table)
    except csv.Error as error:
        raise InputError(f"the table {str(path)!r} is damaged: {error}") from None
    for number, row in enumerate(rows, start=2):
        if None in row or None in row.values():
            raise InputError(f"the table {str(path)!r} has not one entry a column in row {number}")
    return rows


def read_winds(path: Path, missing: bool = False) -> dict[str, dict[str, WindTable]]:
    """Channels over the wind speed by situation and name.

    Columns are ``column``, ``wind_speed_[m/s]`` and ``mean``; ``deviation``, ``least``, ``largest``
    and ``situation``, which is empty without, may be there as well.

    Raises:
        InputError: as `read_rows`, and for words in place of numbers.
    """
    groups: dict[str, dict[str, list[list[float]]]] = {}
    for row in read_rows(path, ("column", WIND, "mean"), missing):
        try:
            values = [float(row.get(key) or "nan") for key in (WIND, *_VALUES)]
        except ValueError as error:
            raise InputError(f"the table {str(path)!r} has an entry: {error}") from None
        groups.setdefault(row.get("situation", ""), {}).setdefault(row["column"], []).append(values)
    return {
        situation: {
            column: WindTable(*np.array(sorted(lines)).T) for column, lines in channels.items()
        }
        for situation, channels in groups.items()
    }


_VALUES = ("mean", "deviation", "least", "largest")
