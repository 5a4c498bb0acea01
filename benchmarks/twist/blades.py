"""Rotation along a blade under unit loads: shells, solid and beams.

Usage: blades.py [FILE ...] [--rows N] [--skip NAME ...]

FILE is a windIO file, or the name of one that comes with windIO. Loads are small. Models are

- "shells" of CalculiX, from a reader apart from this package's, and "held": the same whose sections
  keep their shape in their plane;
- "solid": hollow solid of laminates of this package;
- "file" and "file with the term": beams of the matrices of the file, without and with what inclined
  walls add to them; "prisms" and "inclined": the same from sections of the layup.

Results go to out/, a JSON file for each blade.
"""

import argparse
import json
from pathlib import Path

import calculix_shells
import numpy as np
import ours
import section_motion
import shells
from layup import Blade

from turbine_fenicsx.windio import find_turbine_file

HERE = Path(__file__).parent
OUT = HERE / "out"
FILES = ("IEA-22-280-RWT.yaml", "IEA-15-240-RWT.yaml")
STATIONS = np.arange(0.05, 0.955, 0.05).round(2)
SHOWN = (0.2, 0.4, 0.6, 0.8, 0.9)
LOADS = {
    "1 kN flapwise at the tip": (0, True, 1e3),
    "10 kN m flapwise at the tip": (4, True, 1e4),
    "1 kN/m flapwise": (0, False, 1e3),
    "1 kN edgewise at the tip": (1, True, 1e3),
    "10 kN m edgewise at the tip": (3, True, 1e4),
    "10 kN m torsion at the tip": (5, True, 1e4),
}
"""Component of force and moment, whether at the tip or along the axis, and its size."""


def vector(component, size):
    """Force and moment, (6,)."""
    return size * np.eye(6)[component]


def bend_shells(file, rows, held):
    """Motion of sections of the shells at the stations under each load, (loads, stations, 6)."""
    blade = Blade(find_turbine_file(file))
    mesh = shells.make_shells(blade, rows, 40)
    folder = OUT / f"{Path(file).stem}-{'held' if held else 'shells'}"
    found = calculix_shells.solve(mesh, blade.materials, find_forces(mesh), folder, held)
    return [section_motion.measure(mesh, u, STATIONS) for u in found]


def bend_solid(file, cells=(70, 40)):
    """The same of the solid."""
    solid = ours.make_solid(file, *cells)
    return [section_motion.measure(solid, u, STATIONS) for u in solid.solve(find_forces(solid))]


def find_forces(model):
    """Forces on the nodes of a model for each load [N]."""
    return [
        (section_motion.at_tip if tip else section_motion.along_axis)(model, vector(k, size))
        for k, tip, size in LOADS.values()
    ]


def bend_beam(beam):
    """The same of a beam."""
    return [
        ours.bend_beam(beam, STATIONS, **{"tip" if tip else "line": vector(component, size)})
        for component, tip, size in LOADS.values()
    ]


def compare(file, rows, skip=()):
    """All models of a blade."""
    ways = {
        "shells": lambda: bend_shells(file, rows, False),
        "held": lambda: bend_shells(file, rows, True),
        "solid": lambda: bend_solid(file),
    }
    found = {name: way() for name, way in ways.items() if name not in skip}
    found |= {name: bend_beam(beam) for name, beam in ours.make_beams(file).items()}
    return {
        load: {name: np.asarray(motion[k]).tolist() for name, motion in found.items()}
        for k, load in enumerate(LOADS)
    }


def show(found):
    """Tables of rotation about the span, for Markdown."""
    at = [int(np.argmin(np.abs(STATIONS - s))) for s in SHOWN]
    for load, models in found.items():
        print(f"\n{load}\n")
        for name, motion in models.items():
            rz = 1e6 * np.array(motion)[at, 5]
            print(f"| {name} | " + " | ".join(f"{v:.4g}" for v in rz) + " |")


def main():
    """Compare blades."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("files", nargs="*", default=FILES, metavar="FILE")
    parser.add_argument("--rows", type=int, default=100, help="rows of shells")
    parser.add_argument("--skip", nargs="*", default=(), help="models that are left out")
    options = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    for file in options.files:
        found = compare(file, options.rows, options.skip)
        table = {"stations": STATIONS.tolist(), "loads": found}
        (OUT / f"{Path(file).stem}.json").write_text(json.dumps(table))
        print(f"\n{file}: rotation about the span [1e-6 rad] at {SHOWN} of the span")
        show(found)


if __name__ == "__main__":
    main()
