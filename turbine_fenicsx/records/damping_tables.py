"""Tables of the damping of one mode: numbers, its decay in a run, the work along the blade."""

from __future__ import annotations

import os
from pathlib import Path

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.number_tables import read_columns

DAMPING, DECAY, WORK = "damping.csv", "decay.csv", "work.csv"

_PARTS = tuple(
    family(part=part) for family in (names.MEASURED, names.FITTED) for part in ("real", "imaginary")
)


def read_decay(folder: str | os.PathLike[str]) -> dict[str, Array]:
    """Columns of ``decay.csv``; raises InputError."""
    return read_columns(Path(folder) / DECAY, "table of a decay", (names.TIME, *_PARTS))


def read_work(folder: str | os.PathLike[str]) -> dict[str, Array]:
    """Columns of ``work.csv``; raises InputError."""
    return read_columns(Path(folder) / WORK, "table of works", (names.RADIUS, names.AIR_ALONG))
