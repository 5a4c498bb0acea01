"""Rows of a motion by their times, or by the moments in which something is largest or smallest."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import suggest
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import add_openfast, read_history

_EXTREME = re.compile(r"(max|min)\((.+)\)")


def find_rows(times: Array, wanted: Sequence[float]) -> list[int]:
    """Rows whose times are nearest to wanted ones, in their order and each once.

    Args:
        times: Of the rows, shape (rows,) [s].
        wanted: Times [s].

    Raises:
        InputError: for a time outside of the motion.
    """
    first, last = float(times[0]), float(times[-1])
    slack = 1e-6 * max(abs(last), 1e-3)
    for t in wanted:
        if not first - slack <= t <= last + slack:
            raise InputError(
                f"t = {t:g} s is outside of the motion, which is from {first:g} s to {last:g} s"
            )
    return sorted({int(np.argmin(np.abs(times - t))) for t in wanted})


def find_rows_every(
    times: Array, every: float, begin: float | None = None, end: float | None = None
) -> list[int]:
    """Rows at equal distances of time: the first one in each interval.

    Args:
        times: Of the rows, shape (rows,) [s].
        every: Length of an interval [s], positive.
        begin: Where the first interval begins [s]; with the motion if None.
        end: Time of the last row at most [s]; that of the motion if None.

    Raises:
        InputError: if there is no row.
    """
    first, last = (float(t if x is None else x) for x, t in ((begin, times[0]), (end, times[-1])))
    slack = 1e-6 * max(abs(float(times[-1])), 1e-3)
    inside = np.flatnonzero((times >= first - slack) & (times <= last + slack))
    if not inside.size:
        raise InputError(
            f"the motion has no row from {first:g} s to {last:g} s; it is from {times[0]:g} s to "
            f"{times[-1]:g} s"
        )
    number = np.floor((times[inside] - first + slack) / every)
    found: list[int] = inside[np.unique(number, return_index=True)[1]].tolist()
    return found


def find_moments(
    texts: Sequence[str], folder: Path, recovered: Mapping[str, tuple[Array, Array]]
) -> list[float]:
    """Times by what a user writes: ``12.5``, ``max(tsai_wu)``, ``min(tip_clearance_1)``.

    Args:
        texts: What the user writes.
        folder: Output folder with ``history.csv`` and ``history.out``.
        recovered: Times and values of more names.

    Raises:
        InputError: for texts and names that mean no time.
    """
    return [_find_moment(text.strip(), folder, recovered) for text in texts]


def _find_moment(text: str, folder: Path, recovered: Mapping[str, tuple[Array, Array]]) -> float:
    """The time of one text."""
    match = _EXTREME.fullmatch(text)
    if match is None:
        try:
            time = float(text.removesuffix("s"))
        except ValueError:
            time = np.nan
        if not np.isfinite(time):
            raise InputError(
                f"time {text!r}: expected a number, max(NAME) or min(NAME) with the name of a "
                "failure criterion or of a column of history.csv or history.out"
            )
        return time
    times, values = _find_series(match[2].strip(), folder, recovered)
    if not np.isfinite(values).any():
        raise InputError(f"time {text!r}: the column has no numbers")
    return float(times[(np.nanargmax if match[1] == "max" else np.nanargmin)(values)])


def _find_series(
    name: str, folder: Path, recovered: Mapping[str, tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Times and values of a name, with or without its unit."""
    if name in recovered:
        return recovered[name]
    series, out = read_history(folder / "history.csv"), folder / "history.out"
    column = names.find_column(series.columns, name)
    if column in series.columns:
        return series[names.TIME], series[column]
    found = add_openfast(series, out, [name]) if out.exists() else series
    if name in found.columns:
        return found[names.TIME], found[name]
    known = [*recovered, *(names.split_unit(each)[0] for each in series.columns)]
    raise InputError(
        f"{name!r} is neither a failure criterion nor a column of the run{suggest(name, known)}"
    )
