"""Diagrams of steady states: over the wind speed, and along the blade, beside published ones."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.steady_tables import BLADE, SPAN, STEADY, WIND, read_steady

OVER_WIND = (
    *(names.ROTOR_SPEED, names.PITCH, names.AERO_POWER),
    *(names.AERO_THRUST, names.AERO_TORQUE, "power_coefficient_[-]"),
    *("thrust_coefficient_[-]", "tip_deflection_x_[m]", "tip_rotation_z_[deg]"),
    *("root_moment_x_[Nm]", "root_moment_y_[Nm]", "tower_base_moment_y_[Nm]"),
)
"""Columns over the wind speed; see `choose_columns`."""

ALONG = (
    *("force_x_[N/m]", "force_y_[N/m]", "angle_of_attack_[deg]"),
    *("axial_induction_[-]", "deflection_x_[m]", "rotation_z_[deg]"),
    *("section_force_x_[N]", "section_moment_x_[Nm]", "section_moment_y_[Nm]"),
)
"""Columns along the blade."""

NOTHING = 1e-9
"""Values that are zero in any unit."""

CURVES = 6
"""Maximum number of wind speeds along the blade."""

LINES = ("--", ":", "-.")
"""Of published steady states."""

Table = Mapping[str, Array]


def plot_steady(
    folder: str | os.PathLike[str], beside: Sequence[str | os.PathLike[str]] = ()
) -> list[str]:
    """Draw the steady states in a folder; the names of the pictures.

    Args:
        beside: As of `read_beside`; tables with a column of the place along the blade are drawn
            there.
    """
    folder = Path(folder)
    others = read_beside(beside)
    at_wind = {name: table for name, table in others.items() if SPAN not in table}
    along = {name: table for name, table in others.items() if SPAN in table}
    own = read_steady(folder / STEADY)
    _draw_over_wind(own, at_wind, folder / "steady.png")
    _draw_along(read_steady(folder / BLADE), along, folder / "steady_blade.png")
    return ["steady.png", "steady_blade.png"]


def read_beside(paths: Sequence[str | os.PathLike[str]]) -> dict[str, Table]:
    """Tables of other steady states by the names of their files.

    Raises:
        InputError: if a table cannot be read, or has no column that is drawn.
    """
    found: dict[str, Table] = {Path(path).stem: read_steady(path) for path in paths}
    for name, table in found.items():
        drawn = ALONG if SPAN in table else OVER_WIND
        if not any(column in table for column in drawn):
            raise InputError(
                f"the table {name!r} has no column that is drawn, such as {', '.join(drawn[:3])}"
            )
    return found


def choose_columns(columns: Sequence[str], own: Table) -> list[str]:
    """Columns that are there and more than round-off, as rigid blades have for deflections."""
    return [name for name in columns if np.abs(own.get(name, 0.0)).max() > NOTHING]


def _draw_over_wind(own: Table, others: Mapping[str, Table], path: Path) -> None:
    """Panels over the wind speed."""
    figure, panels = _make_panels(choose_columns(OVER_WIND, own))
    for name, axes in panels.items():
        style = "o-" if len(own[WIND]) < 40 else "-"
        label = "turbine_fenicsx"
        axes.plot(own[WIND], own[name], style, color=PALETTE[0], ms=3.5, lw=1.3, label=label)
        for k, (label, table) in enumerate(others.items()):
            if name in table:
                style, color = LINES[k % len(LINES)], PALETTE[1 + k % (len(PALETTE) - 1)]
                axes.plot(table[WIND], table[name], style, color=color, lw=1.3, label=label)
        axes.set_xlabel("wind speed [m/s]")
    if others:
        next(iter(panels.values())).legend(fontsize=8.0)
    figure.savefig(path)


def _draw_along(own: Table, others: Mapping[str, Table], path: Path) -> None:
    """Panels along the blade, for some of the wind speeds."""
    winds = np.unique(own[WIND])
    shown = winds[np.unique(np.linspace(0, len(winds) - 1, CURVES).round().astype(int))]
    figure, panels = _make_panels(choose_columns(ALONG, own))
    for name, axes in panels.items():
        for k, wind in enumerate(shown):
            color = PALETTE[k % len(PALETTE)]
            rows = own[WIND] == wind
            label = f"{wind:g} m/s"
            axes.plot(own[SPAN][rows], own[name][rows], color=color, lw=1.3, label=label)
            for j, (other, table) in enumerate(others.items()):
                rows = np.isclose(table[WIND], wind)
                if name in table and rows.any():
                    x, y, style = table[SPAN][rows], table[name][rows], LINES[j % len(LINES)]
                    label = f"{wind:g} m/s, {other}"
                    axes.plot(x, y, style, color=color, lw=1.1, label=label)
        axes.set_xlabel("place along the blade [-]")
    next(iter(panels.values())).legend(fontsize=7.0)
    figure.savefig(path)


def _make_panels(columns: Sequence[str]) -> tuple[Any, dict[str, Any]]:
    """A figure with a panel for each column."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        rows = -(-len(columns) // 3)
        figure = Figure(figsize=(12.0, 3.1 * rows), layout="constrained")
        panels = {}
        for k, column in enumerate(columns):
            axes = figure.add_subplot(rows, 3, k + 1)
            name, unit = split_unit(column)
            axes.set_title(f"{name.replace('_', ' ')} [{unit.replace('Nm', 'N m')}]", fontsize=10.0)
            panels[column] = axes
    return figure, panels
