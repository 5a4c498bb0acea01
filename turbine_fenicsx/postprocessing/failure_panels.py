"""Panels of the failure of plies over time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.postprocessing.plot_style import Look, draw_line
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import TimeSeries

SHOWN = 4
"""Panels and webs of a blade that have a curve, those nearest to failure."""


def find_indices(run: TimeSeries) -> tuple[str, Mapping[str, NDArray[np.float64]]]:
    """The first criterion in the columns of a run, and the index of each panel by it."""
    for criterion in CRITERIA:
        found = run.of(names.PLY_INDEX, criterion=criterion)
        if found:
            return criterion, found
    return "", {}


def largest_index(axes: Any, run: TimeSeries, look: Look) -> None:
    """The failure index of the panels nearest to failure; of several runs the largest of all."""
    criterion, found = find_indices(run)
    ranked = sorted(found, key=lambda panel: -float(np.nanmax(found[panel], initial=0.0)))
    if look.alone:
        for panel, color in zip(ranked[:SHOWN], PALETTE, strict=False):
            label = panel.replace("_", " ")
            draw_line(axes, run, found[panel], look, color=color, lw=0.8, label=label)
    elif ranked:
        every = np.max([found[panel] for panel in ranked], axis=0)
        draw_line(axes, run, every, look, color=look.color)
    axes.axhline(1.0, color="#333333", lw=1.0, ls=(0, (6, 3)))
    axes.set(title="Failure of plies", ylabel=f"{criterion}, 1 is failure", ylim=(0.0, None))


def worst_place(axes: Any, run: TimeSeries, look: Look) -> None:
    """Where the largest index of all panels is, from the root."""
    criterion, found = find_indices(run)
    places = run.of(names.PLY_INDEX_AT, criterion=criterion)
    panels = [panel for panel in found if panel in places]
    if panels:
        worst = np.argmax([np.nan_to_num(found[panel]) for panel in panels], axis=0)[None]
        place = np.take_along_axis(np.array([places[panel] for panel in panels]), worst, axis=0)[0]
        axes.plot(run[names.TIME], place, look.marker, ms=2.0, mew=0.0, color=look.color)
    axes.set(title="Place of the largest index", ylabel="from the root [m]")
    axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
