"""The 45-degree bend of Bathe and Bolourchi: bending, twist and stretch together, large.

A beam of the section 1 x 1 lies on an eighth of a circle of the radius 100 in the plane of x and y.
It is clamped where it is tangent to x, and a force at its tip pulls it up, out of that plane.

Here the beam is a solid of quadratic hexahedra. Its faces are flat, so that its axis is a polygon.
The force is a dead load on the face of the tip. `exact.py` solves the equations of the curved beam
with the torsion constant of Saint-Venant for a square, 0.1406, and the solid tends to that. At the
load 600 the distance of the tips falls from 3.6 to 0.37 and 0.053 with 8, 16 and 32 elements along
the beam, 2 by 2 across. With 4 by 4 across it is 0.028, which is 0.05 % of the deflection.

The published positions are 0.5 away from that, 0.8 % of the way. They come from eight straight
elements and, it seems, from the torsion constant 1/6, which would hold if the sections did not
warp. With that the curved beam is within 0.15 and 0.17 of them. A solid with one quadratic element
across, which cannot warp, comes to within 0.03 of the same.
"""

from mpi4py import MPI

import numpy as np
from dolfinx import mesh
from published import Row, references

from turbine_fenicsx import (
    FlexibleBody,
    MultibodySystem,
    StVenantKirchhoff,
    SurfaceTraction,
    equilibrium,
)
from turbine_fenicsx.bodies.coupling import Coupling

RADIUS, ANGLE = 100.0, np.pi / 4.0
YOUNG = 1e7  # nu = 0
LOADS = (300.0, 600.0)
LOAD_STEPS = 3  # to the first load, and from there to the second
ELEMENTS = (32, 4, 4)  # along the axis and across
EXACT = {  # tip of the curved beam, see exact.py
    300: (58.535709, 22.112514, 40.480758),
    600: (46.891586, 15.557676, 53.607986),
}


def bend(comm, elements):
    """Mesh, and the facets at both ends."""
    corners = [(0.0, -0.5, -0.5), (1.0, 0.5, 0.5)]
    solid = mesh.create_box(comm, corners, elements, mesh.CellType.hexahedron)

    def facets(end):
        return mesh.locate_entities_boundary(solid, 2, lambda x: np.isclose(x[0], end))

    ends = facets(0.0), facets(1.0)
    s, y, z = solid.geometry.x.T
    phi, r = ANGLE * s, RADIUS - y
    solid.geometry.x[:] = np.column_stack([r * np.sin(phi), RADIUS - r * np.cos(phi), z])
    return solid, *ends


def solve(elements, loads=LOADS, comm=MPI.COMM_WORLD):
    """Position of the tip under the loads one after the other, shape (loads, 3)."""
    solid, root, tip = bend(comm, elements)
    body = FlexibleBody("bend", solid, StVenantKirchhoff(0.0, 0.5 * YOUNG), 1.0, degree=2)
    pull = SurfaceTraction("pull", body, tip, (0.0, 0.0, 1.0), lambda t: t)
    system = MultibodySystem(comm, [body, Coupling("clamp", body, root, None), pull])
    block, state, found = system.flexible_models[0], None, []
    end = RADIUS * np.array([np.sin(ANGLE), 1.0 - np.cos(ANGLE), 0.0])
    at_end = np.linalg.norm(block.positions - end, axis=1) < 1e-6
    before = 0.0
    for load in loads:
        times = np.linspace(before, load, LOAD_STEPS + 1)[1:]
        state, before = equilibrium(system, times, state), load
        x = block.positions + state.u[0].array_r.reshape(-1, 3)
        found.append(comm.allreduce(x[at_end].sum(axis=0)))
    return np.array(found)


def main(elements=ELEMENTS):
    """Rows of the table."""
    values = {}
    for load, tip in zip(EXACT, solve(elements), strict=True):
        values |= {f"{name}_{load}": x for name, x in zip("xyz", tip, strict=True)}
        values[f"distance_{load}"] = float(np.linalg.norm(tip - EXACT[load]))
    expected = references("bend_45")
    step = " by ".join(map(str, elements)) + " elements"
    return [
        Row(r.quantity, r.unit, r.value, float(values[name]), r.tolerance, step)
        for name, r in expected.items()
    ]
