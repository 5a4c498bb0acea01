"""Wind that changes with the time as a table says, the same over the whole ground.

The speed at a place is that of OpenFAST's uniform wind (InflowWind),

    V = V_hub ((z/z_hub)^alpha + (s_y y' + s_z (z - z_hub))/L) + V_gust

with y' to the left of the wind and L the diameter of the rotor, and the vertical speed across it in
the vertical plane of the wind. Straight lines lead from time to time, and angles turn the short
way. The wind changes everywhere at the same time: it does not travel.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.text_files import quote, read_text
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import FASTEST, turn

COLUMNS = (
    "speed",
    "direction",
    "vertical_speed",
    "horizontal_shear",
    "shear",
    "vertical_shear",
    "gust",
    "inclination",
)
"""Columns of a table, in the order of OpenFAST's files, where the first is the time."""

RANGES = {
    "speed": (0.0, FASTEST),
    "vertical_speed": (-FASTEST, FASTEST),
    "horizontal_shear": (-10.0, 10.0),
    "shear": (-1.0, 2.0),
    "vertical_shear": (-10.0, 10.0),
    "gust": (-FASTEST, FASTEST),
}
"""Plausible range of each column [m/s, -]; angles may have any value."""

_ANGLES = ("direction", "inclination")


@dataclass(frozen=True, eq=False)
class TabulatedWind:
    """The wind of a table.

    Args:
        times: Rising, shape (n,) [s].
        columns: Shape (n,) each, zero where left out: ``speed``, ``gust`` and ``vertical_speed``
            [m/s], ``direction`` from x towards y and upward ``inclination`` [rad], exponent
            ``shear`` and linear ``horizontal_shear`` and ``vertical_shear`` [-].
        hub_height: z_hub, above ground [m].
        diameter: L [m].
    """

    times: Array
    columns: Mapping[str, Array]
    hub_height: float
    diameter: float

    def __post_init__(self) -> None:
        unknown = set(self.columns) - set(COLUMNS)
        if unknown or "speed" not in self.columns:
            raise ModelError(
                f"a table of wind needs the column speed and may have {', '.join(COLUMNS[1:])}, "
                f"got {', '.join(self.columns) or 'none'}"
            )
        for name, values in self.columns.items():
            if np.shape(values) != np.shape(self.times) or not np.all(np.isfinite(values)):
                raise ModelError(f"column {name} of a table of wind needs a number for each time")
        if not np.all(np.diff(self.times) > 0.0):
            raise ModelError("times of a table of wind must rise")
        angles = {key: np.unwrap(self.columns[key]) for key in _ANGLES if key in self.columns}
        object.__setattr__(self, "columns", {**self.columns, **angles})

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`; before the first time and after the last as at these."""
        now = {name: self.at(name, time) for name in COLUMNS}
        x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
        height = np.maximum(z, 0.0) / self.hub_height
        left = y * np.cos(now["direction"]) - x * np.sin(now["direction"])
        linear = now["horizontal_shear"] * left + now["vertical_shear"] * (z - self.hub_height)
        along = now["speed"] * (height ** now["shear"] + linear / self.diameter) + now["gust"]
        ahead = turn(now["direction"], now["inclination"])
        up = turn(now["direction"], now["inclination"] + 0.5 * np.pi)
        return np.asarray(along[..., None] * ahead + now["vertical_speed"] * up)

    def at(self, name: str, time: float) -> float:
        """Value of a column at a time, zero for one that is left out."""
        values = self.columns.get(name)
        return 0.0 if values is None else float(np.interp(time, self.times, values))


def read_uniform_wind(path: str | os.PathLike[str]) -> tuple[Array, dict[str, Array]]:
    """Times and columns of a file of uniform wind of OpenFAST, ``.wnd`` or ``.hh``.

    Its lines have eight or nine numbers: time, speed, direction [deg], vertical speed, linear
    horizontal shear, exponent, linear vertical shear, gust, and upflow angle [deg]. Lines that
    begin with ! or # do not count. Directions are turned to those of `TabulatedWind`: OpenFAST's
    are positive towards -y.
    """
    name, rows = Path(path).name, list[list[float]]()
    for number, line in enumerate(read_text(path, "wind file").splitlines(), start=1):
        text = line.strip()
        if not text or text[0] in "!#":
            continue
        try:
            row = [float(x) for x in text.replace(",", " ").split()]
        except ValueError:
            row = []
        n = len(rows[0]) if rows else len(row)
        if len(row) != n or n not in (8, 9) or not np.all(np.isfinite(row)):
            raise InputError(
                f"{name}, line {number}: expected 8 or 9 finite numbers, time, speed, direction, "
                f"vertical speed, three shears, gust and upflow angle, got {quote(text)}"
            )
        if rows and row[0] <= rows[-1][0]:
            raise InputError(
                f"{name}, line {number}: times must rise, got {row[0]:g} s after {rows[-1][0]:g} s"
            )
        for key, value in zip(COLUMNS, row[1:], strict=False):
            low, high = RANGES.get(key, (-np.inf, np.inf))
            if not low <= value <= high:
                raise InputError(
                    f"{name}, line {number}: {key} = {value:g} must lie between {low:g} and "
                    f"{high:g}"
                )
        rows.append(row)
    if not rows:
        raise InputError(f"{name} holds no wind, expected lines of 8 or 9 numbers")
    values = np.array(rows).T
    columns = dict(zip(COLUMNS, values[1:], strict=False))
    for key in _ANGLES:
        if key in columns:
            columns[key] = np.radians(columns[key])
    columns["direction"] = -columns["direction"]
    return values[0], columns
