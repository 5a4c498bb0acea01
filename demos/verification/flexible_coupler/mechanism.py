"""The slider-crank and its two couplers: a solid, or a chain of rigid pieces on springs."""

import numpy as np
from dolfinx import mesh

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    JointSpring,
    MultibodySystem,
    PrescribedMotion,
    Prismatic,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)
from turbine_fenicsx.foundation.rotations import E1, E3

CRANK, COUPLER, END = 0.2, 1.0, 0.05  # lengths; of each rigid end of the coupler [m]
SPEED, START = 10.0, 0.5  # of the crank, reached smoothly within that time [rad/s], [s]
THICKNESS = 0.02  # square section of all rods [m]
YOUNG, POISSON, DENSITY = 5e8, 0.3, 1000.0  # [Pa], [-], [kg/m^3]
SLIDER = 0.1  # [kg]

PIN = CRANK * E1  # between crank and coupler, at the start
BOLT = (CRANK + COUPLER) * E1  # between coupler and slider
MIDDLE = 0.5 * (PIN + BOLT)


def crank_angle(t):
    """Angle of the crank; its speed rises like a cosine from rest."""
    if t >= START:
        return SPEED * (t - 0.5 * START)
    return 0.5 * SPEED * (t - START / np.pi * np.sin(np.pi * t / START))


def rod(name, start, end):
    """A rigid piece of the coupler, a uniform rod."""
    length, centre = float(np.linalg.norm(end - start)), 0.5 * (start + end)
    mass = DENSITY * THICKNESS**2 * length
    euler = mass / 12.0 * np.array([length**2, THICKNESS**2, THICKNESS**2])
    return RigidBody(name, mass, euler, position=centre)


def mechanism():
    """Crank, both ends of the coupler, slider, and all joints but what is between the ends."""
    crank = RigidBody("crank", 0.2, (1e-3, 1e-5, 1e-5), position=0.5 * PIN)
    first, last = rod("first", PIN, PIN + END * E1), rod("last", BOLT - END * E1, BOLT)
    slider = RigidBody("slider", SLIDER, (1e-5, 1e-5, 1e-5), position=BOLT)
    joints = [
        Revolute("shaft", None, crank, point=(0.0, 0.0, 0.0), axis=E3),
        Revolute("pin", crank, first, point=PIN, axis=E3, with_coordinates=False),
        Revolute("bolt", last, slider, point=BOLT, axis=E3, with_coordinates=False),
        Prismatic("rail", None, slider, point=BOLT, axis=E1),
        PrescribedMotion("shaft", crank_angle),
    ]
    return first, last, [crank, first, last, slider, *joints]


def with_solid(comm, elements):
    """System whose coupler is a solid of quadratic hexahedra, and its two couplings.

    Args:
        comm: Communicator.
        elements: Along the coupler and across.
    """
    first, last, parts = mechanism()
    half = 0.5 * THICKNESS
    ends = PIN[0] + END, BOLT[0] - END
    corners = [(ends[0], -half, -half), (ends[1], half, half)]
    box = mesh.create_box(comm, corners, elements, mesh.CellType.hexahedron)
    mu = 0.5 * YOUNG / (1.0 + POISSON)
    law = StVenantKirchhoff(2.0 * mu * POISSON / (1.0 - 2.0 * POISSON), mu)
    solid = FlexibleBody("coupler", box, law, DENSITY, degree=2)
    couplings = [
        Coupling(
            f"on {carrier.name}",
            solid,
            mesh.locate_entities_boundary(box, 2, lambda x, end=end: np.isclose(x[0], end)),
            carrier,
        )
        for end, carrier in zip(ends, (first, last), strict=True)
    ]
    return MultibodySystem(comm, [*parts, solid, *couplings]), couplings


def with_chain(comm, pieces):
    """System whose coupler is a chain of rigid pieces, and the piece that begins in its middle.

    A spring turns by the curvature times the distance between the middles of its neighbours; the
    two at the ends have only half a piece to themselves.

    Args:
        comm: Communicator.
        pieces: An even number.
    """
    first, last, parts = mechanism()
    points = np.linspace(PIN + END * E1, BOLT - END * E1, pieces + 1)
    links = [rod(f"piece {k}", points[k], points[k + 1]) for k in range(pieces)]
    stiffness = YOUNG * THICKNESS**4 / 12.0 / ((COUPLER - 2.0 * END) / pieces)
    neighbours = [first, *links, last]
    for k, point in enumerate(points):
        factor = 2.0 if k in (0, pieces) else 1.0
        parts.append(Revolute(f"hinge {k}", neighbours[k], neighbours[k + 1], point=point, axis=E3))
        parts.append(JointSpring(f"spring {k}", f"hinge {k}", factor * stiffness))
    return MultibodySystem(comm, [*parts, *links]), links[pieces // 2]
