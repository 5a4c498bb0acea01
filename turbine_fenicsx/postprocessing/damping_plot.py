"""A picture of the damping of a mode: its decay in a run, the work of the air along the blade."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE, STYLE
from turbine_fenicsx.postprocessing.matplotlib_figures import import_matplotlib, save_figure
from turbine_fenicsx.records import names
from turbine_fenicsx.records.damping_tables import read_decay, read_work


def plot_damping(folder: str | os.PathLike[str], png: str | os.PathLike[str]) -> Path:
    """Draw ``decay.csv`` and ``work.csv`` of a folder."""
    decay, work = read_decay(folder), read_work(folder)
    matplotlib, Figure = import_matplotlib()
    time, r, along = decay[names.TIME], work[names.RADIUS], work[names.AIR_ALONG]
    measured, fitted = (
        np.hypot(decay[family(part="real")], decay[family(part="imaginary")])
        for family in (names.MEASURED, names.FITTED)
    )
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.2, 6.4), layout="constrained")
        above, below = figure.subplots(2, 1)
        above.plot(time, decay[names.MEASURED(part="real")], color="#bbbbbb", label="motion")
        above.plot(time, measured, color=PALETTE[0], label="amplitude")
        above.plot(time, fitted, "--", color=PALETTE[1], label="fit")
        above.set_xlabel("time [s]")
        above.set_ylabel("part of the mode [-]")
        above.legend(ncols=3)
        below.fill_between(r, along, where=along >= 0.0, color=PALETTE[2], alpha=0.4, lw=0.0)
        below.fill_between(r, along, where=along <= 0.0, color=PALETTE[1], alpha=0.4, lw=0.0)
        below.plot(r, along, color="black")
        below.axhline(0.0, color="#777777", lw=0.8)
        below.set_xlabel("radius [m]")
        below.set_ylabel("decay rate by the air [1/(m s)]")
        save_figure(figure, png)
    return Path(png)
