"""The small case: a tapered tube of four flat walls under a force at its tip.

Usage: tube.py [--taper T ...]

It is 20 m long and clamped. Its section is 2.0 x 0.8 m at the root, between the middles of walls,
and shrinks about the line through its middle to 1 - T of that at the tip. Walls of 20 mm in front,
4 mm behind and 30 mm above and below do not change along it; E = 70 GPa, nu = 0.3. A force of
100 kN acts across, at the middle of the tip. Beams have matrices of sections by
`turbine_fenicsx.analyse_section`.
"""

import argparse

from mpi4py import MPI

import calculix_shells
import numpy as np
import ours
import section_motion
import shells
from blades import OUT

from turbine_fenicsx import StVenantKirchhoff, _compat, analyse_section
from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.turbine.blades.inclined_walls import incline

LENGTH, WIDE, HIGH, FORCE = 20.0, 2.0, 0.8, 1e5
YOUNG, POISSON = 70e9, 0.3
SHEAR = 0.5 * YOUNG / (1.0 + POISSON)
ALUMINIUM = {"E": YOUNG, "G": SHEAR, "nu": POISSON, "rho": 2700.0}
CORNERS = 0.5 * np.array([[HIGH, WIDE], [HIGH, -WIDE], [-HIGH, -WIDE], [-HIGH, WIDE]])
"""Around the middle of the walls at the root, from the rear wall's upper corner: x, y [m]."""

WALLS = 0.030, 0.020, 0.030, 0.004
"""Thickness of the walls from these corners on: above, in front, below, behind [m]."""

STATIONS = np.array([4.0, 8.0, 12.0, 16.0, 18.0])
GIRTH = 2.0 * (WIDE + HIGH)
TURNS = (
    np.array([0.5 * HIGH, 0.5 * HIGH + WIDE, 1.5 * HIGH + WIDE, 1.5 * HIGH + 2.0 * WIDE]) / GIRTH
)


class Tube:
    """The tube, as `shells.make_shells` wants a blade.

    Args:
        taper: By how much sections shrink from root to tip.
    """

    inset, webs, materials = False, (), {"aluminium": ALUMINIUM}

    def __init__(self, taper):
        self.taper = taper

    def scale(self, s):
        """Size of a section over that at the root."""
        return 1.0 - self.taper * s

    def axes(self, s):
        """Point of the axis and axes of the section as rows."""
        return np.array([0.0, 0.0, s * LENGTH]), np.eye(3)

    def chord(self, s):
        """Unit of the outline [m]."""
        return self.scale(s)

    def outline(self, s):
        """Corners of the middle of the walls and their fractions of the girth."""
        return CORNERS, TURNS

    def panels(self, s):
        """Fractions between which walls lie."""
        return TURNS

    def plies(self, s, arc):
        """Material and thickness of a wall."""
        wall = int(np.searchsorted(TURNS, arc)) - 1
        return [("aluminium", WALLS[wall])]

    def place(self, s, points):
        """Points of a section [m]."""
        flat = self.scale(s) * points
        return np.column_stack([flat, np.full(len(flat), s * LENGTH)])


class TubeBeam:
    """The tube as `exact.make_beam` wants a blade.

    Args:
        tube: The tube.
        inclined: Whether walls are inclined, or those of prisms.
    """

    grid = np.linspace(0.0, 1.0, 11)

    def __init__(self, tube, inclined):
        self.C = np.array([section(tube.scale(s)) + inclined * term(tube, s) for s in self.grid])

    def frames(self, s):
        """Points of the axis and axes of the sections."""
        points = np.outer(s, [0.0, 0.0, LENGTH])
        return points, np.tile(np.eye(3), (len(points), 1, 1))

    def cut(self, s):
        """Points, length per fraction, stiffness and inertia."""
        C = interpolate_matrices(s, self.grid, self.C)
        return self.frames(s)[0], np.full(len(C), LENGTH), C, np.tile(np.eye(6), (len(C), 1, 1))


def section(scale, cells=24):
    """Stiffness matrix of a section as that of a prism, (6, 6)."""
    middle = scale * CORNERS
    t = np.array(WALLS)
    half = 0.5 * np.column_stack([[t[0], t[0], t[2], t[2]], [t[3], t[1], t[1], t[3]]])
    part = np.linspace(0.0, 1.0, 2 * cells, endpoint=False)[:, None]
    loops = []
    for side in (-1.0, 0.0, 1.0):
        corner = middle + side * half * np.sign(CORNERS)
        ahead = np.roll(corner, -1, axis=0)
        loops.append(
            np.concatenate([a + part * (b - a) for a, b in zip(corner, ahead, strict=True)])
        )
    n = len(loops[0])
    points = np.column_stack([np.concatenate(loops), np.zeros(3 * n)])
    k = np.arange(0, n, 2)
    next_, mid = (k + 2) % n, k + 1
    quads = np.column_stack(
        [k, next_, 2 * n + next_, 2 * n + k, mid, n + next_, 2 * n + mid, n + k, n + mid]
    )
    mesh = _compat.mesh_of_arrays(MPI.COMM_SELF, "quadrilateral", 2, points, quads)
    lame = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    return analyse_section(mesh, StVenantKirchhoff(lame, SHEAR), ALUMINIUM["rho"]).stiffness


def term(tube, s, pieces=50):
    """What inclined walls add to the stiffness, (6, 6)."""
    total, rate = np.zeros((6, 6)), -tube.taper / LENGTH
    for a, b, t in zip(CORNERS, np.roll(CORNERS, -1, axis=0), WALLS, strict=True):
        at_root = a + (np.arange(pieces) + 0.5)[:, None] / pieces * (b - a)
        w = np.full(pieces, YOUNG * t * tube.scale(s) * np.linalg.norm(b - a) / pieces)
        total += incline(w, *tube.scale(s) * at_root.T, *rate * at_root.T).sum(axis=0)
    return total


def main():
    """A table for each taper."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--taper", type=float, nargs="+", default=(0.0, 0.3, 0.6, 0.8))
    for taper in parser.parse_args().taper:
        tube, load = Tube(taper), FORCE * np.eye(6)[0]
        mesh = shells.make_shells(tube, 60, 64, face=8)
        print(f"\ntaper {taper:g}: rotation [1e-4 rad] at {STATIONS} m")
        for name, inclined in (("prisms", False), ("with the term", True)):
            beam = ours.demo["exact"].make_beam(TubeBeam(tube, inclined), 100)
            show(name, ours.bend_beam(beam, STATIONS / LENGTH, tip=load))
        for name, held in (("shells held", True), ("shells", False)):
            forces = [section_motion.at_tip(mesh, load)]
            folder = OUT / f"tube-{taper:g}"
            (u,) = calculix_shells.solve(mesh, tube.materials, forces, folder, held)
            show(name, section_motion.measure(mesh, u, STATIONS / LENGTH))


def show(name, motion):
    """A row of the table."""
    print(f"| {name} | " + " | ".join(f"{1e4 * v:.3g}" for v in motion[:, 5]) + " |")


if __name__ == "__main__":
    main()
