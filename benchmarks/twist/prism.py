"""Control: a section of the blade drawn out as a prism turns as its matrices say.

Usage: prism.py [FILE] [--at S ...]

The prism is 14 chords long, in the axes of its section, without twist. Shown are rates of its
middle part: of twist under a force at the tip, of bending under a moment, of twist under a torque;
for shells, for shells whose sections keep their shape, and for the matrices of the file.
"""

import argparse
from functools import cached_property

import calculix_shells
import numpy as np
import section_motion
import shells
from blades import FILES, OUT, vector
from layup import Blade

from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.windio import find_turbine_file, read_turbine

CHORDS = 14
BETWEEN = np.linspace(0.3, 0.7, 41)
"""Part of the length over which rates are fitted."""

LOADS = {
    "twist under 1 kN flapwise": (0, 1e3, 5),
    "bending under 10 kN m flapwise": (4, 1e4, 4),
    "twist under 10 kN m flapwise": (4, 1e4, 5),
    "twist under 10 kN m torsion": (5, 1e4, 5),
}
"""Component of the load, its size, and component of the motion."""


class Prism(Blade):
    """The section of a blade at a span fraction, drawn out straight.

    Args:
        path: The windIO file.
        at: The span fraction.
    """

    def __init__(self, path, at):
        super().__init__(path)
        self.at = at
        chord, offset = float(self.chord(at)), float(self.offset(at))
        self.chord, self.offset = lambda s: chord, lambda s: offset
        self.length = CHORDS * chord

    def axes(self, s):
        """Point of the axis and axes of the section as rows."""
        return np.array([0.0, 0.0, s * self.length]), np.eye(3)

    def outline(self, s):
        """Points of the outline over the chord and their arcs."""
        return super().outline(self.at)

    def panels(self, s):
        """Arcs between which panels lie."""
        return super().panels(self.at)

    def plies(self, s, arc):
        """Materials and thicknesses of the shell's layers."""
        return super().plies(self.at, arc)

    def web_plies(self, s, web):
        """The same of a web."""
        return super().web_plies(self.at, web)

    @cached_property
    def webs(self):
        """Webs, from end to end or nowhere."""
        ends = np.array([0.0, 1.0])
        found = []
        for first, last, places in Blade(self.path).webs:
            there = (0.0, 1.0) if first <= self.at <= last else (-1.0, -1.0)
            parts = [np.interp(self.at, s, part) for _, s, part in places]
            feet = [(place[0], ends, np.full(2, x)) for place, x in zip(places, parts, strict=True)]
            found.append((*there, feet))
        return found


def find_rates(prism, held, rows=80):
    """Rates of the middle part of the shells under each load [1/m]."""
    mesh = shells.make_shells(prism, rows, 40)
    forces = [section_motion.at_tip(mesh, vector(k, size)) for k, size, _ in LOADS.values()]
    found = calculix_shells.solve(mesh, prism.materials, forces, OUT / f"prism-{prism.at:g}", held)
    z = BETWEEN * prism.length
    return [
        np.polyfit(z, section_motion.measure(mesh, u, BETWEEN)[:, k], 1)[0]
        for u, (_, _, k) in zip(found, LOADS.values(), strict=True)
    ]


def expected_rates(file, prism):
    """The same by the matrices of the file."""
    given = read_turbine(find_turbine_file(file)).blade_sections
    C = interpolate_matrices(np.array([prism.at]), given.grid, given.stiffness)[0]
    found = []
    for k, size, motion in LOADS.values():
        load = vector(k, size)
        load[4] += load[0] * (1.0 - BETWEEN.mean()) * prism.length
        found.append(np.linalg.solve(C, load)[motion])
    return found


def main():
    """Compare prisms of some stations."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("file", nargs="?", default=FILES[0])
    parser.add_argument("--at", type=float, nargs="+", default=(0.4, 0.6, 0.8))
    options = parser.parse_args()
    for at in options.at:
        prism = Prism(find_turbine_file(options.file), at)
        columns = [
            expected_rates(options.file, prism),
            *(find_rates(prism, held) for held in (True, False)),
        ]
        print(f"\nprism of the section at {at:g} of the span [1e-9/m]: matrices, held, shells")
        for name, values in zip(LOADS, zip(*columns, strict=True), strict=True):
            print(f"| {name} | " + " | ".join(f"{1e9 * v:.4g}" for v in values) + " |")


if __name__ == "__main__":
    main()
