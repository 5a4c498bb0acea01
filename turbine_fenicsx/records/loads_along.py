"""Forces and moments in sections along a blade, from a table such as ``steady_blade.csv``."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.records import names
from turbine_fenicsx.records.number_tables import read_columns
from turbine_fenicsx.records.steady_tables import SPAN, WIND

COLUMNS = tuple(f(axis=x) for f in (names.SPAN_FORCE, names.SPAN_MOMENT) for x in "xyz")
"""Forces and moments beside the place."""

MOST = 1000
"""States of a table; each has some thousand plies."""


@dataclass(frozen=True, eq=False)
class LoadsAlong:
    """Loads of one state.

    Args:
        wind: Its wind speed; None where the table has none [m/s].
        span: Places as fractions of the length, which rise, shape (m,).
        loads: Forces along x, y, z and moments about them, shape (m, 6) [N, N m].
    """

    wind: float | None
    span: Array
    loads: Array

    def at(self, span: Array) -> tuple[IntArray, Array]:
        """Numbers of the places that these loads hold for, and the loads there, shape (k, 6).

        They are straight between their own places. Those of a single place hold for the nearest.
        """
        if len(self.span) == 1:
            nearest = np.argmin(np.abs(span - self.span[0]))
            return np.array([nearest]), self.loads
        within = np.flatnonzero((span >= self.span[0]) & (span <= self.span[-1]))
        columns = [np.interp(span[within], self.span, column) for column in self.loads.T]
        return within, np.column_stack(columns)


def read_loads(path: str | os.PathLike[str]) -> list[LoadsAlong]:
    """States of a table; a new one begins where the place does not rise or the wind is another.

    Raises:
        InputError: if it lacks a column, or numbers are not finite, or places lie off the blade.
    """
    found = read_columns(path, "table of loads", (SPAN, *COLUMNS))
    span, loads = found[SPAN], np.column_stack([found[name] for name in COLUMNS])
    wind = found.get(WIND, np.zeros_like(span))
    if not all(np.isfinite(x).all() for x in (span, loads, wind)):
        raise InputError(f"the table of loads {str(path)!r} needs finite numbers")
    if np.any((span < 0.0) | (span > 1.0)):
        worst = span[np.argmax(np.abs(span - 0.5))]
        raise InputError(
            f"the table of loads {str(path)!r} has {SPAN} = {worst:g}: fractions of the length are "
            "from 0 to 1"
        )
    new = (np.diff(span) <= 0.0) | (np.diff(wind) != 0.0)
    parts = np.split(np.arange(len(span)), np.flatnonzero(new) + 1)
    if len(parts) > MOST:
        raise InputError(
            f"the table of loads {str(path)!r} has {len(parts)} states; at most {MOST} are allowed"
        )
    given = WIND in found
    return [LoadsAlong(float(wind[k[0]]) if given else None, span[k], loads[k]) for k in parts]
