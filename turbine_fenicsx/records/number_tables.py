"""Tables of numbers from outside: CSV files whose head names the columns."""

from __future__ import annotations

import csv
import os

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import read_text
from turbine_fenicsx.foundation.types import Array


def read_columns(
    path: str | os.PathLike[str], kind: str, needed: tuple[str, ...]
) -> dict[str, Array]:
    """Columns of a table, of equal lengths; lines that begin with # are left out.

    Args:
        kind: What it is to the user, for example "table of steady states".
        needed: Columns that it must have.

    Raises:
        InputError: if it lacks one of these, or has no rows, or something else than numbers.
    """
    lines = [x for x in read_text(path, kind).splitlines() if not x.startswith("#")]
    try:
        head, *rows = list(csv.reader(lines)) or [[]]
    except csv.Error as error:
        raise InputError(f"the {kind} {str(path)!r} is no table of columns: {error}") from None
    missing = [name for name in needed if name not in head]
    if missing or not rows:
        raise InputError(
            f"the {kind} {str(path)!r} needs a column {(missing or list(needed))[0]!r} and rows "
            "with numbers"
        )
    try:
        table = np.array([[float(x) for x in row] for row in rows])
    except ValueError:
        table = np.zeros(0)
    if table.shape != (len(rows), len(head)):
        raise InputError(f"the {kind} {str(path)!r} needs a number in each column of each row")
    return dict(zip(head, table.T, strict=True))
