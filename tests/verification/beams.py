"""Small flexible models for the verification tests: a soft beam on a hub."""

import numpy as np
import ufl
from dolfinx import mesh
from runs import comm

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    Gravity,
    Hat,
    JointTorque,
    MultibodySystem,
    NeoHooke,
    OrthotropicSVK,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)

YOUNG = 1e5  # so soft that the beams below bend by metres [Pa]
GRAVITY = np.array([0.0, -1.0, 0.0])
DURATION, PEAK = 0.4, 3000.0  # of the torque [s], [N m]


def _orthotropic():
    """Fibre at 45 degrees to the beam, so that bending, stretch and twist are coupled."""
    a = np.sqrt(0.5)
    frame = (
        ufl.as_vector((a, a, 0.0)),
        ufl.as_vector((-a, a, 0.0)),
        ufl.as_vector((0.0, 0.0, 1.0)),
    )
    return OrthotropicSVK(
        young=(3 * YOUNG, YOUNG, YOUNG), shear=(0.36 * YOUNG,) * 3, poisson=(0.3,) * 3, frame=frame
    )


LAWS = {
    "transversely_isotropic": _orthotropic,
    "st_venant_kirchhoff": lambda: StVenantKirchhoff(0.8 * YOUNG, 0.4 * YOUNG),
    "neo_hooke": lambda: NeoHooke(0.8 * YOUNG, 0.4 * YOUNG),
}


def beam(law, cell, degree, young=YOUNG):
    """A beam of 4 m x 0.5 m x 0.5 m along e1, its root at x1 = 0.5 m, and its root facets."""
    n = (4, 1, 1) if degree == 1 else (2, 1, 1)
    box = mesh.create_box(
        comm, [(0.5, -0.25, -0.25), (4.5, 0.25, 0.25)], n, getattr(mesh.CellType, cell)
    )
    root = mesh.locate_entities_boundary(box, 2, lambda x: np.isclose(x[0], 0.5))
    return FlexibleBody("beam", box, law, 1000.0, degree), root


def free_machine(law, cell, degree, peak=PEAK):
    """A base, a hub and a beam on it in free fall; an inner torque turns hub against base.

    Nothing ties it to the ground, so that the momenta follow from the weight alone, whatever the
    torque, the joint and the coupling do.
    """
    drift = (0.1, 0.2, -0.05)
    base = RigidBody("base", 400.0, (60.0, 80.0, 100.0), position=(0.0, 0.0, -0.5), velocity=drift)
    hub = RigidBody("hub", 300.0, (30.0, 40.0, 50.0), velocity=drift)
    body, root = beam(LAWS[law](), cell, degree)
    spin = Revolute("spin", base, hub, point=(0.0, 0.0, 0.0), axis=(0.3, 0.0, 1.0))
    parts = [base, hub, body, Coupling("root", body, root, hub), spin]
    loads = [
        JointTorque("torque on spin", "spin", 1.0, Hat(peak, DURATION)),
        Gravity(tuple(GRAVITY)),
    ]
    return MultibodySystem(comm, [*parts, *loads])
