"""``modes.csv`` and ``campbell.csv``: rows of numbers with a name in words, written and read."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import open_regular
from turbine_fenicsx.records import names

Row = Mapping[str, float | str]
"""Column to number, or to text in the column of the name."""


TITLES = "modes"
"""Name of the text in ``modes.xdmf`` that holds the titles of the modes."""


def format_rows(rows: Sequence[Row]) -> str:
    """Rows as text; numbers read back exactly."""
    file = io.StringIO()
    writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(
        {key: x if isinstance(x, str) else f"{x!r}" for key, x in row.items()} for row in rows
    )
    return file.getvalue()


def read_table(path: str | os.PathLike[str]) -> list[dict[str, float | str]]:
    """Read rows."""
    path = Path(path)
    try:
        with io.TextIOWrapper(open_regular(path), encoding="utf-8", newline="") as file:
            lines = list(csv.DictReader(file))
        rows = [
            {key: x if key == names.MODE_NAME else float(x) for key, x in line.items()}
            for line in lines
        ]
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error, TypeError, ValueError):
        raise InputError(f"{path} is not a table of modes") from None
    needed = {names.SPEED, names.MODE, names.FREQUENCY, names.DAMPING_RATIO, names.MODE_NAME}
    if not rows or not needed <= rows[0].keys():
        raise InputError(f"{path} is not a table of modes")
    return rows


@dataclass(frozen=True, eq=False)
class Branch:
    """A mode that is followed over the speed of the rotor, or of the wind.

    Args:
        speeds: Shape (n,) [rpm].
        frequencies: Shape (n,) [Hz].
        damping_ratios: Shape (n,).
        winds: Shape (n,) [m/s]; None without wind.
    """

    name: str
    speeds: NDArray[np.float64]
    frequencies: NDArray[np.float64]
    damping_ratios: NDArray[np.float64]
    winds: NDArray[np.float64] | None = None

    @property
    def places(self) -> NDArray[np.float64]:
        """Winds, or speeds of the rotor without any."""
        return self.speeds if self.winds is None else self.winds


def read_campbell(path: str | os.PathLike[str]) -> list[Branch]:
    """Read the modes of ``campbell.csv``."""
    columns = (names.SPEED, names.FREQUENCY, names.DAMPING_RATIO)
    found: dict[float, list[dict[str, float | str]]] = {}
    for row in read_table(path):
        found.setdefault(float(row[names.MODE]), []).append(row)
    branches = []
    for rows in found.values():
        given = [c for c in (*columns, names.WIND_SPEED) if c in rows[0]]
        values = (np.array([float(row[column]) for row in rows]) for column in given)
        branches.append(Branch(str(rows[-1][names.MODE_NAME]), *values))
    return branches
