"""Four panels of a run in turbulence: power, pitch, flap moment, and how near tips pass the tower.

``python demos/turbulence/draw.py OUT`` writes ``OUT/turbulence.png``, and ``OUT/failure.png`` with
the failure of plies over time, if ``turbine-fenicsx recover OUT`` came before.
"""

import sys
from functools import partial
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.postprocessing.failure_panels import largest_index, worst_place
from turbine_fenicsx.postprocessing.plot_style import draw_line
from turbine_fenicsx.postprocessing.plots import draw
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import read_history

POWER, PITCH = names.AERO_POWER, names.ANGLE(joint="pitch_1")
FLAP = names.ROOT_MOMENT(blade=1, axis="y")
NEAR = 0.5
"""Part of the largest distance below which a tip passes the tower."""


def curve(title, label, find, axes, run, look):
    """A curve over the time."""
    draw_line(axes, run, find(run), look, color=look.color, lw=0.8)
    axes.set(title=title, ylabel=label)


def passages(axes, run, look):
    """The least distance of each tip each time it passes the tower."""
    for (blade, distance), color in zip(run.of(names.TIP_CLEARANCE).items(), PALETTE, strict=False):
        d = distance[1:-1]
        least = (d < distance[:-2]) & (d <= distance[2:]) & (d < NEAR * distance.max())
        times = run[names.TIME][1:-1][least]
        axes.plot(times, d[least], ".", ms=5, color=color, label=f"blade {blade}")
    axes.set(title="Tips that pass the tower", ylabel="distance from the yaw axis [m]")
    axes.set(xlabel="time [s]", ylim=(0.0, None))


def find_moment(run):
    """The flap moment [N m]; the first row has none, as loads are means of a step."""
    return np.concatenate([[np.nan], run[FLAP][1:]])


PANELS = (
    partial(curve, "Power of the air", "power [W]", lambda run: run[POWER]),
    partial(curve, "Pitch", "pitch [deg]", lambda run: -np.degrees(run[PITCH])),
    partial(curve, "Flap moment of blade 1", "at the root [N m]", find_moment),
    passages,
)


def main():
    """Draw a run."""
    folder = Path(sys.argv[1])
    draw([read_history(folder / "history.csv")], PANELS, [folder / "turbulence.png"])
    plies = folder / "plies.csv"
    if plies.exists():
        draw([read_history(plies)], (largest_index, worst_place), [folder / "failure.png"])


if __name__ == "__main__":
    main()
