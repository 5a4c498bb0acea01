"""Diagrams of a load set: channels over the wind speed, extremes, loads of the life, spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.load_sets.lifetime import LIFE
from turbine_fenicsx.load_sets.stored_set import Rows, WindTable
from turbine_fenicsx.postprocessing.page import format_label
from turbine_fenicsx.postprocessing.plot_style import put_prefix_into_label
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import split_unit

ROOT = tuple(names.ROOT_MOMENT(blade=1, axis=axis) for axis in "yx")
BASE = tuple(names.TOWER_BASE_MOMENT(axis=axis) for axis in "yx")
FLAP = names.TIP_FLAP(tip=1)

SHOWN = (
    *("GenPwr_[kW]", names.ROTOR_SPEED, "BldPitch1_[deg]", names.AERO_THRUST),
    *(*ROOT, *BASE, FLAP),
)
"""Channels over the wind speed."""

EXTREME = (*ROOT, *BASE, names.YAW_BEARING_MOMENT(axis="z"), FLAP)
"""Loads whose exceedance is drawn."""

LINES = ("--", ":", "-.")
"""Of other sets."""


def draw_winds(
    own: Mapping[str, WindTable],
    others: Mapping[str, Mapping[str, WindTable]],
    path: Path,
) -> None:
    """Mean with deviation, least and largest value of channels over the wind speed.

    Args:
        own: Channels of a situation.
        others: Channels of other sets by the name of each.
    """
    figure, panels = _make_panels([name for name in SHOWN if name in own])
    for name, axes in panels.items():
        table = own[name]
        limits = table.least, table.largest
        axes.fill_between(table.speeds, *limits, color=PALETTE[0], alpha=0.15, lw=0)
        axes.errorbar(
            table.speeds,
            table.mean,
            table.deviation,
            fmt="o-",
            ms=3.5,
            lw=1.3,
            capsize=2.5,
            color=PALETTE[0],
            label="turbine_fenicsx",
        )
        for k, (label, tables) in enumerate(others.items()):
            if name not in tables:
                continue
            other, color = tables[name], PALETTE[1 + k % (len(PALETTE) - 1)]
            style = LINES[k % len(LINES)]
            axes.plot(other.speeds, other.mean, style, color=color, label=label)
            for edge in other.mean - other.deviation, other.mean + other.deviation:
                axes.plot(other.speeds, edge, style, color=color, lw=0.7)
        axes.set_xlabel("wind speed [m/s]")
        put_prefix_into_label(axes)
    if others:
        next(iter(panels.values())).legend(fontsize=8.0)
    figure.savefig(path)


def draw_exceedance(rows: Rows, path: Path) -> None:
    """Loads over their return periods, with limits of confidence.

    Args:
        rows: Of ``extrapolated.csv``, of one situation.
    """
    found = {row["column"] for row in rows}
    figure, panels = _make_panels([name for name in EXTREME if name in found])
    for name, axes in panels.items():
        for side, color in ("largest", PALETTE[1]), ("least", PALETTE[0]):
            own = [row for row in rows if (row["column"], row["side"]) == (name, side)]
            columns = ("return_period_[years]", "value", "low", "high", "seen")
            if not own:
                continue
            years, value, low, high, seen = np.array(
                [[float(row[key]) for key in columns] for row in own]
            ).T
            axes.fill_between(years, low, high, color=color, alpha=0.2, lw=0)
            axes.plot(years, value, "o-", ms=3.5, color=color, label=side)
            axes.axhline(seen[0], color=color, lw=0.8, ls=(0, (6, 3)), label=f"{side} of the runs")
        axes.set_xscale("log")
        axes.set_xlabel("return period [years]")
        put_prefix_into_label(axes)
    next(iter(panels.values())).legend(fontsize=8.0)
    figure.savefig(path)


def draw_life(rows: Rows, path: Path) -> None:
    """Bars of equivalent loads of the life, each slope of S-N curves in a panel.

    Args:
        rows: Of ``fatigue.csv``.
    """
    import matplotlib
    from matplotlib.figure import Figure

    own = [row for row in rows if row["run"] == LIFE]
    kinds: dict[tuple[str, str], Rows] = {}
    for row in own:
        unit = row["column"].rpartition("_[")[2].rstrip("]")
        kinds.setdefault((row["slope"], unit), []).append(row)
    with matplotlib.rc_context(STYLE):
        heights = [len(found) + 2.0 for found in kinds.values()]
        figure = Figure(figsize=(9.0, 0.28 * sum(heights)), layout="constrained")
        panels = figure.subplots(len(kinds), 1, squeeze=False, height_ratios=heights)
        for axes, ((slope, unit), found) in zip(panels[:, 0], kinds.items(), strict=True):
            words = [row["column"].rpartition("_[")[0].replace("_", " ") for row in found]
            values = [float(row["equivalent_range"]) for row in found]
            axes.barh(words[::-1], values[::-1], color=PALETTE[0], height=0.7)
            scaled, exponent = _scale(max(values))
            axes.set_title(f"S-N slope {float(slope):g}", fontsize=10.0)
            axes.set_xlabel(f"equivalent range [{exponent}{unit.replace('Nm', 'N m')}]")
            axes.xaxis.set_major_formatter(lambda x, _, s=scaled: f"{x / s:g}")
            axes.grid(axis="y", visible=False)
    figure.savefig(path)


def draw_spectra(spectra: Mapping[str, Mapping[float, tuple[Array, Array]]], path: Path) -> None:
    """Power spectral densities of channels at some wind speeds.

    Args:
        spectra: Frequencies [Hz] and densities by channel and wind speed.
    """
    figure, panels = _make_panels([*spectra])
    for name, axes in panels.items():
        for k, (speed, curve) in enumerate(sorted(spectra[name].items())):
            color = PALETTE[k % len(PALETTE)]
            axes.loglog(*curve, color=color, lw=1.0, label=f"{speed:g} m/s")
        words, unit = split_unit(name)
        square = f"({unit.replace('Nm', 'N m')})²/Hz"
        axes.set_ylabel(f"{words.replace('_', ' ')} [{square}]", fontsize=9.0)
        axes.set_xlabel("frequency [Hz]")
    next(iter(panels.values())).legend(fontsize=8.0)
    figure.savefig(path)


def _scale(value: float) -> tuple[float, str]:
    """Power of a thousand below a value, and the prefix of its unit."""
    for factor, prefix in (1e6, "M"), (1e3, "k"), (1.0, ""):
        if value >= factor:
            return factor, prefix
    return 1.0, ""


def _make_panels(columns: Sequence[str]) -> tuple[Any, dict[str, Any]]:
    """A figure with a panel for each column, three in a row."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        rows = -(-len(columns) // 3)
        figure = Figure(figsize=(12.0, 3.1 * rows), layout="constrained")
        panels = {}
        for k, column in enumerate(columns):
            axes = panels[column] = figure.add_subplot(rows, 3, k + 1)
            label = format_label(column).replace("Nm", "N m")
            axes.set_ylabel(label, fontsize=9.0)
    return figure, panels
