"""The Campbell diagram: frequencies over the speed of rotor or wind, from ``campbell.csv``."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.postprocessing.matplotlib_figures import import_matplotlib, save_figure
from turbine_fenicsx.records.mode_tables import Branch, read_campbell

HARMONICS = (1, 3, 6)
"""Multiples of the speed, at which a rotor of three blades is shaken."""

_KINDS = ("flap", "edge", "fore-aft", "side-side", "twist")
"""Words in the names of modes that have a separate colour."""

_GREY = "#777777"
_DASHED: dict[str, Any] = {"color": "#999999", "lw": 0.9, "ls": (0, (5, 3))}
_GAP = 0.031
"""Distance of two names over the height of the panel."""


def plot_campbell(csv_path: str | os.PathLike[str], png: str | os.PathLike[str]) -> Path:
    """Draw the Campbell diagram."""
    branches = read_campbell(csv_path)
    matplotlib, Figure = import_matplotlib()
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.2, 6.4), layout="constrained")
        damped = any(np.any(np.abs(b.damping_ratios) > 1e-6) for b in branches)
        axes = figure.subplots(2 if damped else 1, 1, sharex=True, squeeze=False)[:, 0]
        _draw_frequencies(axes[0], branches)
        if damped:
            figure.set_size_inches(9.2, 9.6)
            _draw_damping(axes[1], branches)
        in_wind = branches[0].winds is not None
        axes[-1].set_xlabel("wind speed [m/s]" if in_wind else "speed of the rotor [rpm]")
        save_figure(figure, png)
    return Path(png)


def _draw_frequencies(axes: Any, branches: Sequence[Branch]) -> None:
    """Frequencies, multiples of the speed, and names."""
    top = 1.06 * max(float(b.frequencies.max()) for b in branches)
    _draw_branches(axes, branches, [b.frequencies for b in branches], top)
    if branches[0].winds is None:
        _draw_harmonics(axes, top)
    else:
        for n in HARMONICS:
            axes.plot(branches[0].winds, n * np.abs(branches[0].speeds) / 60.0, **_DASHED)
    axes.set_ylim(0.0, top)
    axes.set_ylabel("frequency [Hz]")
    axes.set_title("Campbell diagram")


def _draw_harmonics(axes: Any, top: float) -> None:
    """Multiples of the speed, with their names."""
    speeds = np.array(sorted([0.0, *axes.get_xlim()]))
    for n in HARMONICS:
        axes.plot(speeds, n * np.abs(speeds) / 60.0, **_DASHED)
        far = speeds[np.abs(speeds).argmax()]
        place = 0.93 * min(1.0, 60.0 * top / (n * abs(far))) * far
        axes.text(
            place,
            n * abs(place) / 60.0,
            f"{n}P",
            ha="center",
            va="center",
            color=_GREY,
            fontsize=9.0,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
        )


def _draw_damping(axes: Any, branches: Sequence[Branch]) -> None:
    """Damping ratios and names."""
    percent = [100.0 * b.damping_ratios for b in branches]
    highest = max(0.0, *(float(y.max()) for y in percent))
    lowest = min(0.0, *(float(y.min()) for y in percent))
    _draw_branches(axes, branches, percent, highest + 0.06 * (highest - lowest), lowest)
    axes.set_ylabel("damping ratio [%]")


def _draw_branches(
    axes: Any,
    branches: Sequence[Branch],
    values: Sequence[NDArray[np.float64]],
    top: float,
    bottom: float = 0.0,
) -> None:
    """A line for each mode, and its name to the right of it."""
    speeds = branches[0].places
    axes.set_xlim(float(speeds.min()), float(speeds.max()))
    axes.set_ylim(bottom, top)
    heights = spread([(float(y[-1]) - bottom) / (top - bottom) for y in values], _GAP)
    for branch, y, height in zip(branches, values, heights, strict=True):
        colour = _choose_colour(branch.name)
        marker = "o" if len(speeds) < 30 else ""
        axes.plot(branch.places, y, color=colour, marker=marker, ms=2.5)
        axes.annotate(
            branch.name,
            (1.0, (float(y[-1]) - bottom) / (top - bottom)),
            (1.03, height),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            color=colour,
            fontsize=8.5,
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.5, "shrinkA": 1, "shrinkB": 0},
        )


def _choose_colour(name: str) -> str:
    """Colour of the kind of a mode."""
    kind = next((k for k, word in enumerate(_KINDS) if word in name), None)
    return _GREY if kind is None else PALETTE[kind]


def spread(heights: Sequence[float], gap: float) -> list[float]:
    """Heights near given ones that are a gap or more apart, in the same order.

    Neighbours that are too close become a block about the mean of where they want to be.
    """
    order = sorted(range(len(heights)), key=lambda k: heights[k])
    blocks: list[list[int]] = []

    def middle(block: list[int]) -> float:
        return float(np.mean([heights[k] for k in block]))

    for k in order:
        blocks.append([k])
        while len(blocks) > 1:
            low, high = blocks[-2:]
            if middle(high) - middle(low) >= 0.5 * gap * (len(low) + len(high)):
                break
            blocks[-2:] = [low + high]
    found = [0.0] * len(heights)
    for block in blocks:
        for place, k in enumerate(block):
            found[k] = middle(block) + gap * (place - 0.5 * (len(block) - 1))
    return found
