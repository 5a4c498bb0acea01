"""Walls of laminate as strips and tubes, one hexahedron through the thickness.

A strip of 1 m by 0.1 m by 10 mm is clamped at one end and pulled or bent at the other. In its
middle, strains and curvatures are those of classical lamination theory. Plies of carbon lie along
it, across it, at 45 and -45 degrees, or at 30 degrees; one strip is a sandwich with a core of
foam. At 30 degrees the strip shears when it is pulled, and twists when it bends: the coupling by
which a blade twists out of a gust. Strips that bend have the moduli of `layup = "laminate"`,
without which a wall of several plies bends like a uniform one.

A force bends or a torque twists a clamped tube of metal, 60 m long with a radius of 1.5 m and a
wall of 20 mm. A second tube has a radius that falls from 2.5 m to 0.3 m and a wall from 60 mm to 6
mm. A short one is pulled oval at its end. Sixteen cells around are enough for that only with few
points of integration, see [](theory/laminates.md): fully integrated, the section hardly gives way
at all. Vlasov's theory leaves out the shear of the wall, and that rings become longer.

All results are in parts of what theory, or the finest mesh, says. The errors of torsion are those
of the shape of the cells, whose sides are parabolas, and become smaller with nearly the fourth
power of their size. Those of the oval tube are against 40 cells around.
"""

from mpi4py import MPI

import numpy as np
import ufl
from published import Row, load, references

from turbine_fenicsx.materials.ply import Ply, PlyMaterial
from turbine_fenicsx.study.convergence import observed_order

E, NU = 70e9, 0.3
METAL = PlyMaterial("metal", 2700.0, (E,) * 3, (E / 2 / (1 + NU),) * 3, (NU,) * 3)
CARBON = PlyMaterial("carbon", 1580.0, (114e9, 8e9, 8e9), (6e9, 5e9, 4e9), (0.31, 0.3, 0.4))
FOAM = PlyMaterial("foam", 130.0, (130e6, 120e6, 110e6), (49e6, 45e6, 40e6), (0.3, 0.3, 0.3))
LAYUPS = {
    "[0]": ((CARBON, 0.01, 0),),
    "[90]": ((CARBON, 0.01, 90),),
    "[45, -45, -45, 45]": tuple((CARBON, 0.0025, angle) for angle in (45, -45, -45, 45)),
    "[30]": ((CARBON, 0.01, 30),),
    "sandwich": ((CARBON, 0.001, 30), (FOAM, 0.008, 0), (CARBON, 0.001, 30)),
}
STRIP = (1.0, 0.1, 0.01)  # length, width, thickness [m]
SIZE = 1e4  # largest stress at the end [Pa]

LENGTH, SHORT = 60.0, 15.0  # of tubes [m]
TUBES = {  # radius and thickness [m] over the fraction of the length
    "straight": (lambda s: 1.5 + 0 * s, lambda s: 0.02 + 0 * s),
    "tapered": (lambda s: 2.5 - 2.2 * s, lambda s: 0.06 - 0.054 * s),
}
TWISTED, OVAL = (6, 8, 12), (12, 16, 24)  # cells around
FINEST = 40
ORDERS = {"twist": 3.85, "oval": 4.0}
MESH, WALL, EXACT = (load("laminate_walls", name) for name in ("mesh", "loaded_wall", "exact"))


def plies(*layers):
    """Plies of (material, thickness [m], angle [degree]) from the outer to the inner face."""
    return tuple(Ply(material, t, np.deg2rad(angle)) for material, t, angle in layers)


def bend_strip(layup, bend, comm=MPI.COMM_WORLD):
    """Strains and curvatures in the middle of a strip: of the solid, and of the theory.

    Args:
        layup: Name of the laminate.
        bend: Whether it is bent; else it is pulled.
        comm: Communicator.

    Returns:
        Two pairs of (e11, e22, 2 e12) and (k11, k22, 2 k12) [1/m].
    """
    length, width, h = STRIP
    laminate = plies(*LAYUPS[layup])

    def field(X):
        x = ufl.as_vector([1.0, 0.0, 0.0])
        return 2.0 / h * X[2] * x if bend else x

    mesh = MESH.flat_strip(length, width, h, 10, 3)
    # plies that are pulled shear each other at free edges if the wall has their moments, which
    # lamination theory does not know
    moments = bend and len(laminate) > 1
    wall = WALL.LoadedWall(comm, mesh, laminate, h, SIZE, field, moments)
    middle = (wall.number >= 9) & (wall.number < 21)  # 0.3 m to 0.7 m, all of the width
    inner, outer = (wall.mean(np.mean(e, axis=1), middle) for e in wall.strains)
    resultant = SIZE * h**2 / 6.0 if bend else SIZE * h
    found = 0.5 * (inner + outer), (outer - inner) / h
    return found, EXACT.strip(laminate, resultant, bend)


def bend_tube(name, comm=MPI.COMM_WORLD):
    """Deflection of a tube over that of a beam.

    The mesh is graded to the clamped end, where a shell has a boundary layer, and to the tip.
    """
    radius, thickness = TUBES[name]
    ends = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 21))
    mesh = MESH.round_tube(radius, thickness, LENGTH, ends, 12)
    t = thickness(np.mean(mesh.points[mesh.cells][:, :, 0], axis=1) / LENGTH)
    laminates = [plies((METAL, thick, 0)) for thick in t]
    traction = 10.0 / float(2 * np.pi * radius(1.0) * thickness(1.0))
    wall = WALL.LoadedWall(
        comm, mesh, laminates, t, traction, lambda X: ufl.as_vector([0.0, 0.0, 1.0])
    )
    deflection = wall.mean_at(LENGTH, wall.u)[2]
    return deflection / EXACT.bent_tube(radius, thickness, LENGTH, E, METAL.shear[0], 10.0)


def twist_tube(around, comm=MPI.COMM_WORLD):
    """Twist of the straight tube over that of a shaft, T L/(G I_p)."""
    radius, thickness = TUBES["straight"]
    mesh = MESH.round_tube(radius, thickness, LENGTH, 8, around)

    def turn(X):
        return ufl.as_vector([0.0, X[2], -X[1]])

    t = float(thickness(0.0))
    wall = WALL.LoadedWall(comm, mesh, plies((METAL, t, 0)), t, 1.0, turn)
    X, u = wall.positions, wall.u
    angle = (u[:, 1] * X[:, 2] - u[:, 2] * X[:, 1]) / (X[:, 1] ** 2 + X[:, 2] ** 2)
    # the torque is the traction times the polar moment, which is twice the second moment
    return wall.mean_at(LENGTH, angle) * METAL.shear[0] / LENGTH


def pull_oval(around, comm=MPI.COMM_WORLD, **law):
    """How far the short tube becomes oval, over what Vlasov's theory says."""
    r, t = (float(f(0.0)) for f in TUBES["straight"])
    mesh = MESH.round_tube(*TUBES["straight"], SHORT, 12, around)

    def pull(X):
        return ufl.as_vector([0.0, X[1] / r, -X[2] / r])

    wall = WALL.LoadedWall(comm, mesh, plies((METAL, t, 0)), t, 1.0, pull, **law)
    X, u = wall.positions, wall.u
    work = wall.mean_at(SHORT, u[:, 1] * X[:, 1] - u[:, 2] * X[:, 2]) / r
    # the mean of W cos^2 + W/2 sin^2 around the ring
    return work / (0.75 * EXACT.oval_tube(r, t, SHORT, E, NU, 1.0))


def solve_strips(comm=MPI.COMM_WORLD):
    """Strips in parts of lamination theory, by the names of the references."""
    ratios = {}
    for layup in LAYUPS:
        for bend in (False, True):
            found, theory = bend_strip(layup, bend, comm)
            name = f"{layup} {'bend' if bend else 'pull'}"
            ratios[name] = found[bend][0] / theory[bend][0]
            if layup == "[30]":
                ratios[f"{name}, coupled"] = found[bend][2] / theory[bend][2]
    return ratios


def main():
    """Rows of the table."""
    expected = references("laminate_walls")
    twisted, oval = [twist_tube(n) for n in TWISTED], [pull_oval(n) for n in OVAL]
    finest = pull_oval(FINEST)
    ratios = solve_strips() | {
        "straight": bend_tube("straight"),
        "tapered": bend_tube("tapered"),
        "twist": twisted[-1],
        "oval": oval[1] / finest,
        "vlasov": finest,
    }
    errors = {
        "twist": (TWISTED, np.abs(np.array(twisted) - 1.0)),
        "oval": (OVAL, np.abs(np.array(oval) / finest - 1.0)),
    }
    orders = {name: observed_order(1.0 / np.array(n), e) for name, (n, e) in errors.items()}
    return [
        Row(
            r.quantity,
            r.unit,
            r.value,
            float(ratios[name]),
            r.tolerance,
            order=orders.get(name),
            expected_order=ORDERS.get(name, 2.0),
        )
        for name, r in expected.items()
    ]
