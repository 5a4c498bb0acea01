"""What the tests of materials share."""

import numpy as np
import pytest
from dolfinx import mesh
from material_laws import (
    C01,
    C10,
    COMPOSITE,
    KAPPA,
    LAMBDA,
    MU,
    POISSON,
    SHEAR,
    SOFT_FIBRE,
    YOUNG,
    Law,
)

from turbine_fenicsx import (
    MooneyRivlin,
    NeoHooke,
    OrthotropicSVK,
    StVenantKirchhoff,
    TransverselyIsotropic,
)


@pytest.fixture(scope="session")
def cells(comm):
    return mesh.create_box(
        comm, [[0, 0, 0], [1, 1, 1]], [2, 1, 1], cell_type=mesh.CellType.hexahedron
    )


@pytest.fixture(scope="session")
def laws(comm, cells):
    return {
        "svk": Law(comm, cells, lambda _: StVenantKirchhoff(LAMBDA, MU)),
        "neo_hooke": Law(comm, cells, lambda _: NeoHooke(LAMBDA, MU)),
        "orthotropic": Law(
            comm,
            cells,
            lambda a: OrthotropicSVK(young=YOUNG, shear=SHEAR, poisson=POISSON, frame=tuple(a)),
        ),
        "mooney_rivlin": Law(comm, cells, lambda _: MooneyRivlin(C10, C01, KAPPA)),
        "composite": Law(comm, cells, lambda a: TransverselyIsotropic(*COMPOSITE, a[0])),
        "soft_fibre": Law(comm, cells, lambda a: TransverselyIsotropic(*SOFT_FIBRE, a[0])),
    }


@pytest.fixture
def rng():
    return np.random.default_rng(25)
