"""Large deflection of the IEA 22 MW blade under a flapwise line load: shells and solid.

Usage: large.py [--rows N] [--around N] [--only shells | solid]

Loads act on the axis, as forces on the skin that keep their direction. The tip is free. Shells are
those of Kratos, made by a second reader, and stiffer near the tip (`kratos_shells`).
A section turns as the rigid body that fits its nodes best (Kabsch), whose rotation vector is shown.
"""

import argparse

import kratos_shells
import numpy as np
import ours
import section_motion
import shells
from blades import FILES, SHOWN, vector
from layup import Blade
from scipy.spatial.transform import Rotation

from turbine_fenicsx.windio import find_turbine_file

LINE_LOADS = (0.01, *range(1, 10))
"""On each metre of the axis [kN/m]."""

PARTS = 4
"""Steps of the shells from one to the next."""


def turn_sections(model, u, s):
    """Displacement of the axis and rotation vector of sections at span fractions, (len(s), 6)."""
    found = []
    for (numbers, weights), origin in zip(model.rows, model.axis, strict=True):
        before, after = model.nodes[numbers], model.nodes[numbers] + u[numbers]
        middles = [np.average(x, axis=0, weights=weights) for x in (before, after)]
        turn, _ = Rotation.align_vectors(after - middles[1], before - middles[0], weights)
        moved = middles[1] + turn.apply(origin - middles[0]) - origin
        found.append(np.concatenate([moved, turn.as_rotvec()]))
    return np.array([np.interp(s, model.stations, column) for column in np.transpose(found)]).T


def main():
    """A table of both models at all loads."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--rows", type=int, default=200, help="rows of shells")
    parser.add_argument("--around", type=int, default=60, help="shells around a section")
    parser.add_argument("--only", choices=("shells", "solid"), help="one of the models")
    options = parser.parse_args()
    file = find_turbine_file(FILES[0])
    ways = {"shells": lambda: _bend_shells(file, options), "solid": lambda: _bend_solid(file)}
    print(f"rotation about the span [1e-3 rad] at {SHOWN}, and deflection at the last [m]")
    for name, way in ways.items():
        if options.only not in (None, name):
            continue
        model, found = way()
        for load, u in zip(LINE_LOADS, found, strict=False):
            motion = turn_sections(model, u, SHOWN)
            twist = " | ".join(f"{1e3 * v:.4g}" for v in motion[:, 5])
            print(f"| {name}, {load:g} kN/m | {twist} | {motion[-1, 0]:.5g} |")


def _bend_shells(file, options):
    blade = Blade(file)
    mesh = shells.make_shells(blade, options.rows, options.around, high=6, face=2)
    model = kratos_shells.Quadrilaterals.of(mesh)
    force = section_motion.along_axis(model, vector(0, 1e3))
    factors = [LINE_LOADS[0], *np.arange(1, PARTS * LINE_LOADS[-1] + 1) / PARTS]
    found = kratos_shells.solve(model, blade.materials, force, factors)
    return model, found[::PARTS]


def _bend_solid(file):
    solid = ours.make_solid(file, 40, 32)
    return solid, solid.bend(section_motion.along_axis(solid, vector(0, 1e3)), LINE_LOADS)


if __name__ == "__main__":
    main()
