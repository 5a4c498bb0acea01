"""Panels of several runs: one quantity in each, so that lines can distinguish the runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from turbine_fenicsx.postprocessing.panels import Panel, small_energies
from turbine_fenicsx.postprocessing.plot_style import Look
from turbine_fenicsx.records.output_folder import TimeSeries


def split_panels(panels: Sequence[Panel], runs: Sequence[TimeSeries]) -> list[Panel]:
    """Panels that show one quantity each where there are several runs.

    Returns:
        The panels themselves for a single run.
    """
    if len(runs) < 2:
        return list(panels)
    found: list[Panel] = []
    for panel in panels:
        quantities = _list_quantities(panel, runs)
        if not quantities:
            found.append(panel)
        elif panel is not small_energies:  # they have panels already
            alone = len(quantities) == 1
            found += [_show_one(panel, quantity, alone) for quantity in quantities]
    return found


def _list_quantities(panel: Panel, runs: Sequence[TimeSeries]) -> list[str]:
    """The quantities that a panel shows of any run."""
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    for run in runs:
        panel(axes, run, Look(alone=False))
    labels = axes.get_legend_handles_labels()[1]
    names = {run.name for run in runs}
    return [label for label in dict.fromkeys(labels) if label not in names]


def _show_one(panel: Panel, quantity: str, alone: bool) -> Panel:
    """A panel with one of its quantities, or the only one, in the colours of the runs."""

    def draw(axes: Any, run: TimeSeries, look: Look) -> None:
        before = set(axes.get_lines())
        panel(axes, run, look)
        for line in set(axes.get_lines()) - before:
            if line.get_label() == quantity:
                line.set(color=look.color, label=run.name)
            elif not line.get_label().startswith("_"):
                line.remove()
        axes.relim()
        title = axes.get_title("left")
        if not alone:
            repeats = quantity.lower().startswith(title.lower())
            axes.set_title(quantity.capitalize() if repeats else f"{title}: {quantity}")

    return draw
