"""A small hollow blade of one cell through the wall, clamped, and bases of it."""

from functools import cache

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import (
    BladeGeometry,
    Coupling,
    FlexibleBody,
    KelvinVoigt,
    MultibodySystem,
    StVenantKirchhoff,
    reduce_body,
)
from turbine_fenicsx.meshing import load_arrays
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_shape import EllipticShape
from turbine_fenicsx.meshing.model import MeshArrays

COMM = MPI.COMM_WORLD
GEOMETRY = BladeGeometry(
    hub_radius=1.0,
    length=20.0,
    stations=(0.0, 1.0),
    chord=(1.6, 0.7),
    thickness=(1.0, 0.3),
    wall=(0.06, 0.03),
    twist=(0.15, 0.0),
)
LAME, DENSITY = (4e9, 6e9), 1800.0
TAU = 0.002
"""Time that the law takes to creep [s]."""


@cache
def blade(cells=(6, 8)):
    """The body and the facets of its root."""
    block = mesh_hollow(EllipticShape(GEOMETRY), *cells)
    n = len(block.root)
    arrays = MeshArrays(
        block.reference,
        block.points,
        block.cells,
        np.ones(len(block.cells), dtype=np.int64),
        block.root,
        np.ones(n, dtype=np.int64),
        {"blade": 1},
        {"root": 1},
    )
    loaded = load_arrays(COMM, lambda: arrays, "blade")
    law = KelvinVoigt(
        StVenantKirchhoff(*LAME), TAU * LAME[1], TAU * (LAME[0] + 2.0 / 3.0 * LAME[1])
    )
    return FlexibleBody("blade", loaded.mesh, law, DENSITY, 2), loaded.facets("root")


def clamped(body=None):
    """The blade, or what takes its place, on the ground."""
    full, root = blade()
    body = full if body is None else body
    return MultibodySystem(COMM, [body, Coupling("root", body, root, None)])


@cache
def basis(functions=36, **options):
    """A basis of four modes that has seen smooth loads."""
    return reduce_body(clamped(), blade()[0], 4, functions, **options)
