"""Claims about the points at which walls are sampled: no locking, and no motion without energy."""

from itertools import product

from mpi4py import MPI

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import eigsh
from walls import CARBON, FOAM, GLASS, laminate, load_wall, wall_arrays

from turbine_fenicsx import KelvinVoigt, StVenantKirchhoff, cell_field
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls, total_thickness
from turbine_fenicsx.materials.wall_quadrature import STABILISING, wall_quadrature
from turbine_fenicsx.system.flexible_model import FlexibleModel

SANDWICH = laminate((GLASS, 0.001, 30), (FOAM, 0.018, 0), (GLASS, 0.001, 30))
UNEVEN = laminate((CARBON, 0.008, 20), (FOAM, 0.01, 0), (GLASS, 0.002, -45))
SHAPES = {
    "cube": lambda s, a, z: np.stack([s, a, z], axis=-1),
    "plate": lambda s, a, z: np.stack([s, a, 0.02 * z], axis=-1),
    "arc": lambda s, a, z: cylinder(s, 0.4 * a, 1.0 + 0.02 * z),
    "twisted": lambda s, a, z: cylinder(2 * s + 0.1 * a, 0.4 * a + 0.3 * s, 1 - 0.3 * s + 0.02 * z),
}


def cylinder(x, angle, radius):
    return np.stack(np.broadcast_arrays(x, radius * np.sin(angle), radius * np.cos(angle)), axis=-1)


def wall_body(comm, arrays, plies, moments=True, **law):
    loaded, number = load_wall(comm, arrays)
    thickness = np.full(len(number), total_thickness(plies))
    table = tabulate_walls([plies] * len(number), thickness, moments)
    material = Laminate(
        cell_field(loaded.mesh, table.in_plane), cell_field(loaded.mesh, table.through), **law
    )
    density = cell_field(loaded.mesh, table.density)
    return FlexibleBody("wall", loaded.mesh, material, density, degree=2)


def matrices(body):
    """Stiffness at rest and mass of a body on one rank."""
    model = FlexibleModel(body)
    u, K, M = model.new_vector(), model.new_stiffness(), model.mass_matrix()
    model.assemble_stiffness(u, 0.0, K)
    found = []
    for matrix in (K, M):
        starts, columns, values = matrix.getValuesCSR()
        found.append(csr_matrix((values, columns, starts)))
    for item in (u, K, M):
        item.destroy()
    return found


def test_polynomials_are_integrated_exactly():
    """All but the stabilising share around and through the wall."""
    points, weights = wall_quadrature()
    for powers in product(range(6), range(4), range(4)):
        exact = 1.0 / np.prod(np.add(powers, 1))
        tolerance = 1e-13 if max(powers[1:]) < 2 else STABILISING
        assert weights @ np.prod(points**powers, axis=1) == pytest.approx(exact, abs=tolerance)


@pytest.mark.parametrize("plies", [SANDWICH, UNEVEN], ids=["sandwich", "uneven"])
@pytest.mark.parametrize("shape", SHAPES)
def test_nothing_but_rigid_motion_of_a_cell_is_without_energy(shape, plies):
    """Two points along the span would leave 33 motions."""
    K, _ = matrices(wall_body(MPI.COMM_SELF, wall_arrays(SHAPES[shape], 1, 1), plies))
    values = np.linalg.eigvalsh(K.toarray()) / K.diagonal().max()
    # bending of a plate is (thickness/length)^2/12 times softer than stretching, or 1e-5
    assert np.all(np.abs(values[:6]) < 1e-12)
    assert values[6] > 1e-8


def test_no_mode_of_a_tube_is_softer_than_it_should_be():
    """With 45 degrees a cell, those that are hardly sampled lie above bending into four waves."""

    def frequencies(span, around):
        tube = wall_arrays(
            lambda s, a, z: cylinder(6 * s, 2 * np.pi * a, 1.0 + 0.02 * z), span, around, True
        )
        K, M = matrices(wall_body(MPI.COMM_SELF, tube, UNEVEN))
        squares = eigsh(K, 14, M, sigma=-1e3, return_eigenvectors=False)
        return np.sqrt(np.abs(np.sort(squares))) / (2 * np.pi)

    coarse, fine = frequencies(3, 8), frequencies(8, 12)
    assert np.all(coarse[:6] < 1e-3 * fine[6])
    assert np.all(coarse[6:] > 0.97 * fine[6:])


def test_viscous_walls_are_sampled_as_elastic_ones(comm):
    body = wall_body(comm, wall_arrays(SHAPES["arc"], 2, 2), UNEVEN)
    assert KelvinVoigt(body.material, 1.0).quadrature is body.material.quadrature
    assert KelvinVoigt(StVenantKirchhoff(1.0, 1.0), 1.0).quadrature is None
    viscous = FlexibleBody("v", body.mesh, KelvinVoigt(body.material, 1.0), 1.0, degree=2)
    energies = []
    for model in (FlexibleModel(body), FlexibleModel(viscous)):
        u = model.new_vector()
        u.array[:] = (0.1 * model.positions**2).ravel()
        energies.append(comm.allreduce(model.strain_energy(u)))
        u.destroy()
    assert energies[0] == pytest.approx(energies[1], rel=1e-13)
