"""Large deflection: shells and solid of the IEA 22 MW blade under a flapwise line load.

Usage: large.py [--load N_PER_M] [--rows N]

Loads act on the axis, as forces on the skin that keep their direction. The tip is free. A section
turns as the rigid body that fits its nodes best (Kabsch), whose rotation vector is shown.
"""

import argparse

import calculix_shells
import numpy as np
import ours
import section_motion
import shells
from blades import FILES, OUT, SHOWN, vector
from layup import Blade
from scipy.spatial.transform import Rotation

from turbine_fenicsx.windio import find_turbine_file

PARTS = 5


def turn_sections(nodes, rows, axis, stations, u, s):
    """Displacement of the axis and rotation vector of sections at span fractions, (len(s), 6)."""
    found = []
    for (numbers, weights), origin in zip(rows, axis, strict=True):
        before, after = nodes[numbers], nodes[numbers] + u[numbers]
        middles = [np.average(x, axis=0, weights=weights) for x in (before, after)]
        turn, _ = Rotation.align_vectors(after - middles[1], before - middles[0], weights)
        moved = middles[1] + turn.apply(origin - middles[0]) - origin
        found.append(np.concatenate([moved, turn.as_rotvec()]))
    return np.array([np.interp(s, stations, column) for column in np.transpose(found)]).T


def main():
    """A table of both models at parts of the load."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--load", type=float, default=9000.0, help="on each metre of the axis [N]")
    parser.add_argument("--rows", type=int, default=100, help="rows of shells")
    options = parser.parse_args()
    line = vector(0, options.load)
    blade = Blade(find_turbine_file(FILES[0]))
    mesh = shells.make_shells(blade, options.rows, 40)
    solid = ours.make_solid(FILES[0], 40, 32)
    force = section_motion.along_axis(mesh, line)
    steps = [part * force for part in (np.arange(PARTS) + 1.0) / PARTS]
    found = calculix_shells.solve(mesh, blade.materials, steps, OUT / "large", large=True)
    axis = [frame[0] for frame in mesh.frames[::2]]
    models = {
        "shells": (found, mesh.nodes, mesh.rows, axis, mesh.stations),
        "solid": (
            solid.bend(solid.along_axis(line), PARTS),
            *(solid.nodes, solid.rows, solid.axis, solid.stations),
        ),
    }
    print(f"rotation about the span [1e-3 rad] at {SHOWN}, and deflection at the last [m]")
    for name, (found, *place) in models.items():
        for part, u in enumerate(found, start=1):
            motion = turn_sections(*place, u, SHOWN)
            twist = " | ".join(f"{1e3 * v:.4g}" for v in motion[:, 5])
            load = part / PARTS * options.load / 1e3
            print(f"| {name}, {load:g} kN/m | {twist} | {motion[-1, 0]:.4g} |")


if __name__ == "__main__":
    main()
