"""The modes of a turbine as files: ``modes.csv``, ``modes.xdmf``, ``campbell.csv``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees, pi
from pathlib import Path

from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import TITLES, Row, format_rows
from turbine_fenicsx.simulation.mode_shapes import write_mode_shapes
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.modes.mode_table import ModeRow

RPM = 30.0 / pi
"""Revolutions per minute of one rad/s."""


@dataclass(frozen=True)
class Place:
    """Where modes are looked at.

    Args:
        speed: Of the rotor [rad/s].
        wind: Speed of the wind [m/s]; None without air.
        pitch: Of the blades in the wind [rad].
        is_free: Whether the wind follows from the speed: it gives the rotor no torque.
    """

    speed: float
    wind: float | None = None
    pitch: float = 0.0
    is_free: bool = False


@dataclass(frozen=True)
class ModeTable:
    """The modes at one place."""

    place: Place
    rows: tuple[ModeRow, ...]


def write_tables(folder: Path, turbine: Turbine, tables: Sequence[ModeTable]) -> list[str]:
    """Write ``modes.csv``, and of several speeds ``campbell.csv``; their names. Collective."""
    rows = [
        _make_row(table.place, number, row)
        for table in tables
        for number, row in enumerate(table.rows, start=1)
    ]
    files = {"modes.csv": rows}
    if len(tables) > 1:
        columns = (*_make_head(tables[0].place), names.MODE, names.FREQUENCY)
        columns = (*columns, names.DAMPING_RATIO, names.MODE_NAME)
        files["campbell.csv"] = [{column: row[column] for column in columns} for row in rows]
    for name, content in files.items():
        text = format_rows(content).encode()
        on_rank0(turbine.comm, partial(replace_file, folder / name, text))
    return list(files)


def write_shapes(folder: Path, turbine: Turbine, modes: Modes, table: ModeTable) -> str:
    """Write ``modes.xdmf``; its name. Collective."""
    grid = FieldGrid(
        turbine.system, turbine.surfaces(), turbine.parts_of_cells(), turbine.part_names()
    )
    titles = [
        f"{k}  {row.name}\n{_describe_frequency(row)}" for k, row in enumerate(table.rows, start=1)
    ]
    write_mode_shapes(folder / "modes.xdmf", grid, modes, {TITLES: json.dumps(titles)})
    return "modes.xdmf"


def describe_place(place: Place) -> str:
    """A place in the wind in words."""
    return (
        f"{place.wind:.4g} m/s, {place.speed * RPM:.4g} rpm, pitch {degrees(place.pitch):.4g} deg"
    )


def format_modes(table: ModeTable) -> str:
    """The modes at one place as lines to read."""
    parts = [part.replace("_", " ") for part in table.rows[0].shares]
    damped = any(abs(row.damping_ratio) > 5e-6 for row in table.rows)
    head = ["", "f [Hz]", *["damping"] * damped, *parts, "moves", "name"]
    lines = [head]
    for number, row in enumerate(table.rows, start=1):
        falls = row.growth and not row.frequency
        frequency = "grows" if falls else f"{row.frequency:.4f}"
        damping = ["" if falls else f"{100.0 * row.damping_ratio:.2f} %"] * damped
        shares = [f"{100.0 * x:.0f} %" for x in row.shares.values()]
        ways = sorted(row.ways.items(), key=lambda item: -item[1])
        motion = ", ".join(f"{way} {100.0 * x:.0f} %" for way, x in ways[:2] if x > 0.095)
        lines.append([str(number), frequency, *damping, *shares, motion, row.name])
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    left = len(head) - 2  # words stand to the left, numbers to the right
    return "\n".join(
        "  ".join(
            cell.ljust(width) if k >= left else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def _make_head(place: Place) -> dict[str, float]:
    """The first columns of ``modes.csv``."""
    if place.wind is None:
        return {names.SPEED: place.speed * RPM}
    turning = {names.SPEED: place.speed * RPM, names.PITCH: degrees(place.pitch)}
    if place.is_free:
        return {**turning, names.FREE_WIND: place.wind}
    return {names.WIND_SPEED: place.wind, **turning}


def _make_row(place: Place, number: int, row: ModeRow) -> Row:
    """A row of ``modes.csv``."""
    return {
        **_make_head(place),
        names.MODE: number,
        names.FREQUENCY: row.frequency,
        names.DAMPING_RATIO: row.damping_ratio,
        names.GROWTH_RATE: row.growth,
        **{names.MODAL_MASS(part=part): x for part, x in row.shares.items()},
        **{
            names.MOTION_SHARE(way=way.replace(" ", "_").replace("-", "_")): x
            for way, x in row.ways.items()
        },
        names.MODE_NAME: row.name,
    }


def _describe_frequency(row: ModeRow) -> str:
    """Frequency and damping of a mode in words."""
    if row.growth and not row.frequency:
        return f"grows by a factor of e in {1.0 / row.growth:.3g} s"
    damped = abs(row.damping_ratio) > 5e-6
    damping = f", damping {100.0 * row.damping_ratio:.2f} %" if damped else ""
    return f"{row.frequency:.3f} Hz{damping}"
