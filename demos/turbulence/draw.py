"""Four panels of a run in turbulence: power, pitch, flap moment, and clearance of the first blade.

``python demos/turbulence/draw.py OUT`` writes ``OUT/turbulence.png``.
"""

import sys
from functools import partial
from pathlib import Path

import numpy as np

from turbine_fenicsx.postprocessing.panels import is_turbine
from turbine_fenicsx.postprocessing.plot_style import draw_line
from turbine_fenicsx.postprocessing.plots import draw
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import read_history

POWER, PITCH = names.AERO_POWER, names.ANGLE(joint="pitch_1")
FLAP, CLEARANCE = names.ROOT_MOMENT(blade=1, axis="y"), names.TIP_CLEARANCE(tip=1)


def curve(title, label, find, axes, run, look):
    """A curve of the first blade, or of all."""
    assert is_turbine(run)
    draw_line(axes, run, find(run), look, color=look.color, lw=0.8)
    axes.set(title=title, ylabel=label)


def find_moment(run):
    """The flap moment [N m]; the first row has none, as loads are means of a step."""
    return np.concatenate([[np.nan], run[FLAP][1:]])


PANELS = (
    partial(curve, "Power of the air", "power [W]", lambda run: run[POWER]),
    partial(curve, "Pitch", "pitch [deg]", lambda run: -np.degrees(run[PITCH])),
    partial(curve, "Flap moment", "at the root [N m]", find_moment),
    partial(curve, "Clearance", "tip to yaw axis [m]", lambda run: run[CLEARANCE]),
)


def main():
    """Draw a run."""
    folder = Path(sys.argv[1])
    draw([read_history(folder)], PANELS, [folder / "turbulence.png"])


if __name__ == "__main__":
    main()
