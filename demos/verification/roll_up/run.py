"""A cantilever rolled up to a circle by a moment at its end.

A beam of length `L` that is bent by the moment `M = 2 pi E I / L` at its end has the curvature
`2 pi / L` everywhere: it closes to a circle.

Here the beam is a solid of quadratic hexahedra, 10 m x 0.1 m x 0.1 m, of a St. Venant-Kirchhoff
material with `nu = 0`, clamped at one end and coupled to a rigid plate at the other; the moment
acts on the plate. Beam theory holds for thin beams only: the fibres are stretched by 3 %, and the
stress of the material is not proportional to that. `exact.py` has the exact solution of the bent
solid, which turns the plate by 2.00397 pi; the solid nearly tends to it. The difference is that the
plates keep both ends from getting thinner. Halving the elements along the beam makes the error ten
times smaller; how many there are across it hardly matters.
"""

from mpi4py import MPI

import numpy as np
from dolfinx import mesh
from published import Row, references

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    MultibodySystem,
    RigidBody,
    StVenantKirchhoff,
    Torque,
    equilibrium,
)
from turbine_fenicsx.study.convergence import observed_order

LENGTH, THICKNESS, YOUNG = 10.0, 0.1, 1e9  # [m], [m], [Pa]
LOAD_STEPS = 4
ELEMENTS = (40, 80, 160)  # along the beam
ACROSS = 2  # elements in the plane of bending; one in the other direction

SLOW = True


def solve(elements, thickness=THICKNESS, comm=MPI.COMM_WORLD):
    """Angle of the plate [rad] and distance between its middle and the clamp [m]."""
    half = 0.5 * thickness
    corners = [(0.0, -half, -half), (LENGTH, half, half)]
    box = mesh.create_box(comm, corners, (elements, ACROSS, 1), mesh.CellType.hexahedron)
    beam = FlexibleBody("beam", box, StVenantKirchhoff(0.0, 0.5 * YOUNG), 1.0, degree=2)
    root, tip = (
        mesh.locate_entities_boundary(box, 2, lambda x, end=end: np.isclose(x[0], end))
        for end in (0.0, LENGTH)
    )
    plate = RigidBody("plate", 1.0, (1.0, 1.0, 1.0), position=(LENGTH, 0.0, 0.0))
    moment = 2.0 * np.pi * YOUNG * thickness**4 / 12.0 / LENGTH
    parts = [
        beam,
        plate,
        Coupling("clamp", beam, root, None),
        Coupling("end", beam, tip, plate),
        Torque("moment", plate, (0.0, 0.0, moment), lambda t: t),
    ]
    system, state, angle = MultibodySystem(comm, parts), None, 0.0
    for load in np.linspace(0.0, 1.0, LOAD_STEPS + 1)[1:]:
        state = equilibrium(system, (load,), state)
        d1 = state.q[3:6]
        turned = np.array([np.cos(angle), np.sin(angle), 0.0])
        side = np.array([-np.sin(angle), np.cos(angle), 0.0])
        angle += np.arctan2(d1 @ side, d1 @ turned)
    return {"angle": angle, "gap": float(np.linalg.norm(state.q[:3]))}


def main(elements=ELEMENTS):
    """Rows of the table."""
    expected = references("roll_up")
    runs = [solve(n) for n in elements]
    errors = np.array([abs(run["angle"] - expected["solid"].value) for run in runs])
    order = observed_order(1.0 / np.array(elements[-2:]), errors[-2:])
    values = {"beam": runs[-1]["angle"], "gap": runs[-1]["gap"], "solid": runs[-1]["angle"]}
    return [
        Row(
            quantity=r.quantity,
            unit=r.unit,
            reference=r.value,
            value=values[name],
            tolerance=r.tolerance,
            step=f"{elements[-1]} by {ACROSS} by 1 elements",
            order=order if name == "solid" else None,
            expected_order=3.4,
        )
        for name, r in expected.items()
    ]
