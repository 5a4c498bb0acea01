"""Error over size of a refinement, both logarithmic."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.postprocessing.plots import PALETTE
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.study.convergence import Series

_MARKERS = "os^Dvp"
STYLE = {
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.which": "major",
    "axes.axisbelow": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "savefig.dpi": 200,
}


def plot_convergence(series: Sequence[Series], size: str, title: str, path: Path) -> None:
    """Draw one panel per quantity, one line per series, and the fitted power law of each.

    Args:
        size: What the size is, for the label of the axis.
        title: Title of the figure, may be empty.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.ticker import LogLocator, NullLocator

    quantities = list(dict.fromkeys(s.quantity for s in series))
    columns = min(len(quantities), 3)
    rows = -(-len(quantities) // columns)
    with matplotlib.rc_context(STYLE):
        layout = ConstrainedLayoutEngine()
        figure = Figure(figsize=(4.2 * columns + 0.4, 3.4 * rows + 0.6), layout=layout)
        lines: dict[str, Any] = {}
        for k, quantity in enumerate(quantities):
            axes = figure.add_subplot(rows, columns, k + 1)
            for j, s in enumerate(s for s in series if s.quantity == quantity):
                usable = np.isfinite(s.errors) & (s.errors > 0.0)
                h, e = s.sizes[usable], s.errors[usable]
                color = PALETTE[j % len(PALETTE)]
                order = f"order {s.order:.2f}" if np.isfinite(s.order) else "no order"
                if np.isfinite(s.order) and not s.is_checked:
                    order += ", not checked"
                marker = _MARKERS[j % len(_MARKERS)]
                (line,) = axes.loglog(h, e, marker, color=color, ms=5.0, label=order)
                if s.label:
                    lines[s.label] = line
                if np.isfinite(s.order):
                    fit = np.exp(np.mean(np.log(e)) + s.order * (np.log(h) - np.mean(np.log(h))))
                    axes.loglog(h, fit, "-", color=color, lw=1.0)
            name, unit = name_and_unit(quantity)
            axes.set(title=name, xlabel=size, ylabel=f"error{unit}")
            sizes = sorted({h for s in series if s.quantity == quantity for h in s.sizes})
            axes.set_xticks(sizes, [f"{h:.3g}" for h in sizes])
            axes.xaxis.set_minor_locator(NullLocator())
            axes.yaxis.set_major_locator(LogLocator(numticks=8))
            axes.legend()
        if lines:
            place = {"loc": "lower center", "ncols": columns}
            figure.legend(list(lines.values()), list(lines), **place)
            below = 0.26 * -(-len(lines) // columns) / figure.get_figheight()
            layout.set(rect=(0.0, below, 1.0, 1.0 - below))
        if title:
            figure.suptitle(title, x=0.01, ha="left")
        figure.savefig(path)


def name_and_unit(quantity: str) -> tuple[str, str]:
    """A column such as ``tip_deflection_1_[m]`` as words, and its unit in brackets."""
    name, unit = split_unit(quantity)
    return name.replace("_", " "), unit and f" [{unit}]"
