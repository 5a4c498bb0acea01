"""The modes of a turbine as one HTML page that needs no other file and no network."""

import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.campbell import plot_campbell
from turbine_fenicsx.postprocessing.mode_pictures import LOOK, render_modes
from turbine_fenicsx.postprocessing.page import (
    embed_figure,
    fill_page,
    format_case,
    format_grid,
    format_note,
)
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import read_table
from turbine_fenicsx.records.output_folder import need_folder, read_tables

_SIZE = (800, 960)
"""Of the pictures, of which the page shows a sheet [pixels]."""

Table = list[dict[str, float | str]]


def report_modes(
    folder: str | os.PathLike[str],
    scale: float = 1.0,
    pictures: bool = True,
    describe: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict,
) -> str:
    """Describe the modes in a folder.

    Args:
        scale: Factor of the motion in the pictures.
        describe: Makes the tables of the page from those of ``case.json``.
    """
    folder = need_folder(folder)
    rows = read_table(folder / "modes.csv")
    case = read_tables(folder / "case.json")
    in_wind = names.WIND_SPEED in rows[0]
    column, unit = (names.WIND_SPEED, "m/s") if in_wind else (names.SPEED, "rpm")
    speeds = list(dict.fromkeys(float(row[column]) for row in rows))
    last = [row for row in rows if row[column] == speeds[-1]]
    at = f"at {speeds[-1]:.4g} {unit}" if speeds[-1] else "at rest"
    sections = {
        f"Modes {at}": _format_modes(last),
        "Campbell diagram": _draw_campbell(folder, in_wind) if len(speeds) > 1 else "",
        f"Shapes {at}": _draw_shapes(folder, scale) if pictures else "",
        "Case": format_case(case, describe),
    }
    count = f"{len(last)} modes {at}"
    if len(speeds) > 1:
        count = f"{len(last)} modes at {len(speeds)} speeds up to {speeds[-1]:.4g} {unit}"
    title = str((case or {}).get("title") or folder.resolve().name)
    return fill_page(title, f"{folder.resolve().name}, {count}", sections)


def _format_modes(rows: Table) -> str:
    """The table of the modes; columns without anything in them are left out."""
    percent = {
        column: column.removeprefix(family.pattern.partition("{")[0]).removesuffix("_[-]")
        for family in (names.MODAL_MASS, names.MOTION_SHARE)
        for column in family.find(rows[0]).values()
    }
    shown = [c for c in percent if any(float(row[c]) >= 0.005 for row in rows)]
    damped = any(abs(float(row[names.DAMPING_RATIO])) > 5e-6 for row in rows)
    head = ["", "mode", "Hz", *(["damping"] if damped else [])]
    head += [percent[column].replace("_", " ") for column in shown]
    lines = []
    for row in rows:
        growth = float(row.get(names.GROWTH_RATE, 0.0)) and not float(row[names.FREQUENCY])
        cells = [str(row[names.MODE_NAME]), f"{float(row[names.MODE]):g}"]
        cells.append("grows" if growth else f"{float(row[names.FREQUENCY]):.4f}")
        if damped:
            cells.append("" if growth else f"{100.0 * float(row[names.DAMPING_RATIO]):.2f} %")
        cells += [f"{100.0 * float(row[column]):.0f} %" for column in shown]
        lines.append(cells)
    return (
        "<p>Of the modal mass: blades, tower, and nacelle with hub. Of the motion of all cross-"
        "sections, blades seen from what carries them: flap and so on.</p>\n"
        f"{format_grid(head, lines)}"
    )


def _draw_campbell(folder: Path, in_wind: bool) -> str:
    """The Campbell diagram."""
    with tempfile.TemporaryDirectory() as scratch:
        try:
            path = plot_campbell(folder / "campbell.csv", Path(scratch) / "campbell.png")
        except ImportError as error:
            return format_note(f"There is no diagram: {error}.")
        over = "the wind speed" if in_wind else "the speed of the rotor"
        words = f"Frequencies over {over}; the dashed lines are 1, 3 and 6 times that of the rotor."
        return embed_figure(path, words)


def _draw_shapes(folder: Path, scale: float) -> str:
    """A sheet of all shapes."""
    with tempfile.TemporaryDirectory() as scratch:
        try:
            look = replace(LOOK, scale=scale, size=_SIZE)
            *_, path = render_modes(folder / "modes.xdmf", scratch, look=look)
        except InputError as error:
            reason = str(error).rpartition(f"{scratch}{os.sep}")[2]
            return format_note(f"There are no pictures: {reason}.")
        words = "Shapes, and in grey the turbine at rest. Red is what moves most."
        return embed_figure(path, words)
