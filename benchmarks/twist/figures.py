"""Pictures of what `blades.py` and `wind.py` have found, into docs/images.

Usage: figures.py [--out FOLDER]
"""

import argparse
import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import wind
from blades import HERE, OUT

IMAGES = HERE.parents[1] / "docs" / "images"
STYLES = {
    "shells": ("shells of CalculiX", {"color": "k", "marker": "o", "ls": "", "mfc": "none"}),
    "solid": ("hollow solid, here", {"color": "C0", "lw": 2.5}),
    "file with the term": ("beam with the term, here", {"color": "C2", "ls": "--"}),
    "file": ("beam of prisms: what beam codes have", {"color": "C3"}),
}
TITLES = ("1 kN flapwise at the tip", "10 kN m flapwise at the tip", "1 kN/m flapwise")
CURVES = {
    "HAWC2": ("HAWC2", {"color": "0.6", "lw": 4}),
    "OpenFAST": ("OpenFAST", {"color": "0.35", "ls": ":", "lw": 3}),
    "beams": ("beams of prisms, here", {"color": "C3"}),
    "inclined": ("beams with the term, here", {"color": "C2", "ls": "--"}),
    "reduced solids": ("reduced solids, here", {"color": "C0"}),
    "solids": ("full solids, here", {"color": "k", "marker": "s", "ls": "", "mfc": "none"}),
}


def draw_blades(path):
    """Rotation along the blade under three loads."""
    table = json.loads((OUT / "IEA-22-280-RWT.json").read_text())
    figure, axes = plt.subplots(1, len(TITLES), figsize=(11, 3.6), layout="constrained")
    for ax, load in zip(axes, TITLES, strict=True):
        for name, (label, style) in STYLES.items():
            motion = np.array(table["loads"][load][name])
            ax.plot(table["stations"], 1e6 * motion[:, 5], label=label, **style)
        ax.axhline(0.0, color="0.8", lw=0.8, zorder=0)
        ax.set(title=load, xlabel="span [-]", xlim=(0.0, 1.0))
    axes[0].set_ylabel("rotation about the span [10⁻⁶ rad]")
    axes[1].legend(fontsize=8, loc="upper left")
    figure.savefig(path, dpi=120)


def draw_wind(path):
    """Thrust, power and twist over the wind speed."""
    found = wind.gather()
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    for name, (label, style) in CURVES.items():
        winds, whole, twist = found[name]
        axes[0].plot(winds, whole["aero_thrust_[N]"] / 1e6, label=label, **style)
        axes[1].plot(winds, whole["aero_power_[W]"] / 1e6, label=label, **style)
        axes[2].plot(winds, twist[:, -1], label=label, **style)
    labels = "thrust [MN]", "power [MW]", "twist at 0.9 of the span [deg]"
    for ax, label in zip(axes, labels, strict=True):
        ax.set(xlabel="wind speed [m/s]", ylabel=label)
    axes[2].legend(fontsize=8)
    figure.savefig(path, dpi=120)


def main():
    """Draw both."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--out", type=Path, default=IMAGES)
    folder = parser.parse_args().out
    draw_blades(folder / "twist.png")
    draw_wind(folder / "twist_wind.png")


if __name__ == "__main__":
    main()
