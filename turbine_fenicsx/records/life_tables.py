"""Tables of the life of plies, written by the command ``life`` and read by its diagrams."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import read_text
from turbine_fenicsx.records import names

PLACES, SECTION, WINDS = "life.csv", "life_section.csv", "life_winds.csv"
"""Places where plies fail first, damage around the section of the first, and by wind speed."""

BONDS = "life_bonds.csv"
"""Where each bond fails first."""

FIELDS, BLADE, ROSETTE, CURVE = "life.vtkhdf", "life.png", "life_section.png", "life_winds.png"
"""Fields, and pictures of the blade and of both other tables."""

ALL = (PLACES, SECTION, WINDS, BONDS, FIELDS, BLADE, ROSETTE, CURVE)
"""All files of the life."""

NEEDED = {
    PLACES: (
        *("panel", "ply", "plies", "material", "measure", "run"),
        *(names.DISTANCE, names.DAMAGE, names.LIFE),
    ),
    SECTION: (
        *(names.SECTION_END(end=end, axis=axis) for end in ("start", "end") for axis in "yx"),
        *(names.SECTION_NORMAL(axis=axis) for axis in "yx"),
        *("panel", names.DAMAGE, names.FATIGUE_INDEX, names.DISTANCE, "blade"),
    ),
    WINDS: (names.WIND_SPEED, names.DAMAGE),
    BONDS: ("bond", "measure", "run", names.DISTANCE, names.DAMAGE, names.LIFE),
}
"""Columns that readers need."""


def read_life_table(folder: str | os.PathLike[str], name: str) -> list[dict[str, str]]:
    """Rows of a table of `NEEDED` in a folder.

    Raises:
        InputError: for a file that cannot be read, or is another.
    """
    path = Path(folder) / name
    rows = list(csv.DictReader(read_text(path, "table of the life of plies").splitlines()))
    try:
        for row in rows:
            for column in NEEDED[name]:
                if column.endswith("]"):
                    float(row[column])
                elif not isinstance(row[column], str):
                    raise KeyError(column)
    except (KeyError, ValueError, TypeError):
        rows = []
    if not rows:
        raise InputError(f"{str(path)!r} is no table of the life of plies, or is damaged")
    return rows
