"""Diagrams of the life of plies: damage around a section, and by wind speed."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing.colours import colour_map, round_up
from turbine_fenicsx.postprocessing.matplotlib_figures import import_matplotlib, save_figure
from turbine_fenicsx.records import names
from turbine_fenicsx.records.life_tables import (
    CURVE,
    PLACES,
    ROSETTE,
    SECTION,
    WINDS,
    read_life_table,
)

Rows = list[dict[str, str]]

BAR = 0.25
"""Length of the longest bar of a rosette, relative to the width of the section."""


def plot_life(folder: str | os.PathLike[str]) -> list[Path]:
    """Draw the tables of a folder; the pictures in it.

    Raises:
        ImportError: without Matplotlib.
        InputError: for damaged tables.
    """
    (place, *_), section, winds = (
        read_life_table(folder, name) for name in (PLACES, SECTION, WINDS)
    )
    paths = [Path(folder) / name for name in (ROSETTE, CURVE)]
    _draw_rosette(section, paths[0])
    _draw_winds(winds, place, paths[1])
    return paths


def _draw_rosette(rows: Rows, png: Path) -> None:
    """The section with a bar on each cell, as long as its fatigue index."""
    matplotlib, Figure = import_matplotlib()
    from matplotlib.collections import LineCollection, PolyCollection

    start, end = (
        _columns(rows, [names.SECTION_END(end=end, axis=axis) for axis in "yx"])
        for end in ("start", "end")
    )
    normal = _columns(rows, [names.SECTION_NORMAL(axis=axis) for axis in "yx"])
    (index,) = _columns(rows, [names.FATIGUE_INDEX]).T
    largest, width = max(float(index.max()), 1e-30), float(np.ptp(np.concatenate([start, end])))
    out = (BAR * width * index / largest)[:, None] * normal
    colours = matplotlib.colors.ListedColormap(colour_map())
    scale = matplotlib.colors.Normalize(0.0, round_up(largest))
    with matplotlib.rc_context(STYLE):
        height, length = np.ptp(np.concatenate([start + out, end + out, start]), axis=0)[::-1]
        figure = Figure(figsize=(9.2, 1.8 + 7.5 * min(height / length, 1.0)), layout="compressed")
        axes = figure.subplots()
        bars = PolyCollection(
            np.stack([start, end, end + out, start + out], axis=1),
            facecolors=colours(scale(index)),
            edgecolors="#6b7280",
            linewidths=0.3,
        )
        axes.add_collection(bars)
        axes.add_collection(LineCollection(np.stack([start, end], axis=1), colors="black", lw=1.4))
        worst = int(np.argmax(index))
        tip = 0.5 * (start + end + 2.0 * out)[worst]
        axes.annotate(
            f"{index[worst]:.3g}",
            tip,
            tip + 0.06 * width * normal[worst],
            ha="center",
            va="center",
            color=PALETTE[0],
            bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "none", "alpha": 0.8},
        )
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.margins(0.06)
        axes.set_xlabel("to the trailing edge [m]")
        axes.set_ylabel("to the suction side [m]")
        distance, blade = float(rows[0][names.DISTANCE]), rows[0]["blade"]
        axes.set_title(f"blade {blade}, {distance:.4g} m from the root", fontsize=11.0)
        mappable = matplotlib.cm.ScalarMappable(scale, colours)
        figure.colorbar(mappable, ax=axes, label="fatigue index [-]", shrink=0.8)
        save_figure(figure, png)


def _draw_winds(rows: Rows, place: dict[str, str], png: Path) -> None:
    """Damage of one place by wind speed, and its sum up to each."""
    matplotlib, Figure = import_matplotlib()
    wind, damage = _columns(rows, [names.WIND_SPEED, names.DAMAGE]).T
    width = 0.8 * (float(np.min(np.diff(wind))) if len(wind) > 1 else 1.0)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.2, 4.4), layout="constrained")
        axes = figure.subplots()
        axes.bar(wind, damage, width, color=PALETTE[0], label="of each wind speed")
        axes.plot(wind, np.cumsum(damage), "o-", color=PALETTE[1], label="up to each")
        axes.set_xlabel("wind speed [m/s]")
        axes.set_ylabel("damage in the life [-]")
        axes.set_xticks(wind)
        words = place["panel"].replace("_", " ")
        axes.set_title(f"ply {place['ply']} of {words}, {place['material']}", fontsize=11.0)
        axes.legend(loc="upper left")
        save_figure(figure, png)


def _columns(rows: Rows, wanted: list[str]) -> Array:
    """Numbers of columns, shape (rows, columns)."""
    return np.array([[float(row[name]) for name in wanted] for row in rows])
