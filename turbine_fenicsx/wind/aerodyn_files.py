"""Polars and blades in the files of AeroDyn 15."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.wind.aero_blade import STATION_TOLERANCE, AeroBlade
from turbine_fenicsx.wind.aerodyn_text import AeroDynText
from turbine_fenicsx.wind.polar import Polar

BLADE_COLUMNS = {"BlSpn": 0, "BlCrvAC": 1, "BlSwpAC": 2, "BlTwist": 4, "BlChord": 5, "BlAFID": 6}
"""Columns that are read of a blade, and where they are without names above them."""

_SWEEP = 1e-3
"""Sweep up to this is none [m]."""


class PolarColumns(NamedTuple):
    """Columns of a polar's table, counted from 1, under AeroDyn's names without `InCol_`.

    Attributes:
        Cm: Moment; 0 for none, None for the fourth column where there is one.
    """

    Alfa: int = 1
    Cl: int = 2
    Cd: int = 3
    Cm: int | None = None


COLUMNS = PolarColumns()
"""Columns of AeroDyn's examples."""


def read_aerodyn_polar(
    path: str | os.PathLike[str], columns: PolarColumns = COLUMNS, first_alone: bool = True
) -> Polar:
    """The first table of a file with the coefficients of an aerofoil.

    Args:
        path: A file of AeroDyn 15.
        columns: Where the coefficients are.
        first_alone: Whether tables after the first have no effect; else a file has one table.

    Raises:
        InputError: if it is none, its table does not close the circle, or there are more tables.
        FileError: if it cannot be read.
    """
    text = AeroDynText.read(path)
    count, first = text.find_count("NumAlf")
    number = text.find("NumTabs")
    if not first_alone and number and number[0] not in ("1", "01"):
        text.fail(
            number[1],
            f"it has {number[0]} tables, between which AFTabMod = 2 or 3 interpolates, which is "
            "not done here: leave the table of rated operation, or set AFTabMod = 1 for the first",
        )
    least = max(c or 0 for c in columns)
    table = text.read_table(first, count, least)
    moment = columns.Cm if columns.Cm is not None else 4 * (table.shape[1] >= 4)
    angle, lift, drag = (table[:, c - 1] for c in columns[:3])
    C_m = table[:, moment - 1] if moment else np.zeros(count)
    try:
        return Polar(Path(path).stem, np.radians(angle), lift, drag, C_m)
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def read_aerodyn_blade(
    path: str | os.PathLike[str], hub_radius: float, polars: Sequence[Polar]
) -> AeroBlade:
    """A blade with chord, twist and polars along its span.

    Columns are found by the names above them. The blade warns of sweep, which is left out.

    Args:
        path: A blade file of AeroDyn 15.
        hub_radius: Where the blade begins [m].
        polars: Those the column BlAFID counts from 1.

    Raises:
        InputError: if the file is none, or names a polar that is not given.
        FileError: if it cannot be read.
    """
    text = AeroDynText.read(path)
    count, first = text.find_count("NumBlNds")
    places = _find_columns(text, first)
    table = text.read_table(first, count, max(places.values()) + 1)
    span, prebend, sweep, twist, chord, numbers = (table[:, places[name]] for name in BLADE_COLUMNS)
    strangers = sorted({float(n) for n in numbers if n not in range(1, len(polars) + 1)})
    if strangers:
        raise InputError(
            f"{os.fspath(path)} names polar {strangers[0]:g} in column BlAFID, but {len(polars)} "
            "polars are given"
        )
    radius = hub_radius + span
    tip = float(radius[-1])
    radius = np.clip(radius, hub_radius + STATION_TOLERANCE, tip - STATION_TOLERANCE)
    largest = float(np.abs(sweep).max())
    warnings = (
        f"{Path(path).name}: its blade is swept by up to {largest:.3g} m (BlSwpAC), which is left "
        "out: sections lie on a straight or prebent span",
    )
    try:
        return AeroBlade(
            hub_radius,
            tip,
            radius,
            chord,
            np.radians(twist),
            tuple(polars[int(n) - 1] for n in numbers),
            prebend=prebend,
            warnings=warnings if largest > _SWEEP else (),
        )
    except ModelError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def _find_columns(text: AeroDynText, first: int) -> dict[str, int]:
    """Indices of the columns of a blade, by their names where there are any."""
    names = text.lines[first].replace(",", " ").lower().split() if first < len(text.lines) else []
    if "blspn" not in names:
        return BLADE_COLUMNS
    missing = [name for name in BLADE_COLUMNS if name.lower() not in names]
    if missing:
        text.fail(first, f"the table of the blade has no column {missing[0]}")
    return {name: names.index(name.lower()) for name in BLADE_COLUMNS}
