"""Elastic bricks, clamped or free, and the frequencies of modes."""

import numpy as np
from dolfinx import mesh

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
from turbine_fenicsx.system.system import MultibodySystem

LAME, DENSITY = (0.4e9, 0.5e9), 1000.0


def box(comm, size, cells):
    """A brick from the origin along the axes."""
    return mesh.create_box(comm, [[0.0] * 3, size], cells, mesh.CellType.hexahedron)


def facets_at(cells, x):
    return mesh.locate_entities_boundary(cells, 2, lambda X: np.isclose(X[0], x))


def brick(comm, size=(1.0, 0.2, 0.3), cells=(4, 1, 2), name="beam"):
    return FlexibleBody(
        name, box(comm, list(size), list(cells)), StVenantKirchhoff(*LAME), DENSITY, 2
    )


def clamped(body):
    return Coupling(f"root of {body.name}", body, facets_at(body.mesh, 0.0), None)


def frequencies(found):
    return np.array([m.frequency for m in found.modes])


def body_system(comm, body):
    return MultibodySystem(comm, [body, clamped(body)])
