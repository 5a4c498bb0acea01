"""A small flexible body for tests of its model and its steps: all laws, cells and degrees.

States are far from any solution, and functions of the position only, so that they do not depend
on how the mesh is distributed; numbers are compared with hand calculations or with themselves on
one rank.
"""

import numpy as np
import pytest
from dolfinx import fem, mesh

from turbine_fenicsx import NeoHooke, OrthotropicSVK, StVenantKirchhoff
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel

KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
LAWS = ("svk", "orthotropic", "neo_hooke")
SIZE, DENSITY = np.array([1.0, 0.5, 0.4]), 3.0
MASS = DENSITY * np.prod(SIZE)
LAMBDA, MU = 6.0, 4.0
GRAVITY = np.array([0.5, -9.81, 2.0])
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)
EPS = np.finfo(float).eps

all_kinds = pytest.mark.parametrize(("cell", "degree"), KINDS)
all_laws = pytest.mark.parametrize("law", LAWS)


def small_body(comm, cell, degree, law, fibre=False, make_loads=lambda body: ()):
    """The model of a box of two by one by one cells."""
    cells = mesh.create_box(comm, [[0, 0, 0], SIZE], [2, 1, 1], getattr(mesh.CellType, cell))
    axes = [fem.Constant(cells, a.copy()) for a in FRAME.T]
    material = {
        "svk": StVenantKirchhoff(LAMBDA, MU),
        "neo_hooke": NeoHooke(LAMBDA, MU),
        "orthotropic": OrthotropicSVK(
            young=(20.0, 8.0, 7.0), shear=(4, 3, 2.5), poisson=(0.3, 0.25, 0.3), frame=tuple(axes)
        ),
    }[law]
    body = FlexibleBody("b", cells, material, DENSITY, degree, axes[0] if fibre else None)
    return FlexibleModel(body, make_loads(body))


def nodal(model, values):
    """Vector with the values at the owned nodes, a function of their positions X."""
    vector = model.new_vector()
    vector.array[:] = np.asarray(values(model.positions), dtype=float).ravel()
    return vector


def wild(seed, size):
    """A field that looks random: waves much shorter than the elements."""
    rng = np.random.default_rng(seed)
    K, phase = rng.uniform(5, 30, (3, 3)), rng.uniform(0, 7, 3)
    return lambda X: size * np.sin(X @ K + phase)


def affine(H, shift=(0.0, 0.0, 0.0)):
    """The field H X + shift."""
    return lambda X: X @ np.asarray(H).T + shift


def total(model, values):
    """Sum over the nodes of all ranks."""
    return model.body.mesh.comm.allreduce(np.asarray(values).sum(axis=0))


def energy(model, u):
    """Strain energy on all ranks."""
    return model.body.mesh.comm.allreduce(model.strain_energy(u))


def kinetic(model, v):
    """Kinetic energy on all ranks."""
    p = model.new_vector()
    model.momentum(v, p)
    return 0.5 * v.dot(p)
