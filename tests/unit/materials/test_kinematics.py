"""Claims about strain measures in UFL; oracle: numpy."""

import numpy as np
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx.materials.kinematics import (
    deformation_gradient,
    green_lagrange,
    right_cauchy_green,
)


def test_strain_measures_of_an_affine_displacement_equal_numpy(comm):
    cells = mesh.create_box(comm, [[0, 0, 0], [1, 1, 1]], [2, 1, 1])
    H = fem.Constant(cells, np.random.default_rng(1).normal(size=(3, 3)) * 0.3)
    chosen = fem.Constant(cells, np.zeros((3, 3)))
    F = deformation_gradient(ufl.dot(H, ufl.SpatialCoordinate(cells)))
    C = right_cauchy_green(F)
    for tensor, expected in (
        (F, np.eye(3) + H.value),
        (C, (np.eye(3) + H.value).T @ (np.eye(3) + H.value)),
        (green_lagrange(C), 0.5 * (H.value + H.value.T + H.value.T @ H.value)),
    ):
        form = fem.form(ufl.inner(tensor, chosen) * ufl.dx(domain=cells))
        found = np.zeros((3, 3))
        for i in range(3):
            for j in range(3):
                chosen.value = np.outer(np.eye(3)[i], np.eye(3)[j])
                found[i, j] = comm.allreduce(fem.assemble_scalar(form))  # volume one
        assert np.allclose(found, expected, rtol=0, atol=1e-14)  # sums over a dozen cells
