"""Claims about strain and stress as DOLFINx functions."""

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx import (
    BodyFields,
    FlexibleBody,
    KelvinVoigt,
    ModelError,
    MultibodySystem,
    NeoHooke,
    StVenantKirchhoff,
    TransverselyIsotropic,
    cell_field,
)
from turbine_fenicsx.system.cell_centres import CellCentres

pytestmark = pytest.mark.parallel

LAM, MU = 3e7, 2e7
CELLS = {"tetrahedron": mesh.CellType.tetrahedron, "hexahedron": mesh.CellType.hexahedron}
SHIFT = np.array([[0.1, 0.25, -0.05], [-0.3, 0.2, 0.15], [0.05, -0.1, -0.15]])
"""Gradient of the displacement: large stretches, shear and a rotation."""


def box(cell="hexahedron", comm=MPI.COMM_WORLD):
    return mesh.create_box(comm, [(0, 0, 0), (2, 1, 0.5)], [3, 2, 2], CELLS[cell])


def make(material, cell="hexahedron", degree=1):
    body = FlexibleBody("body", box(cell), material, 1000.0, degree=degree)
    return MultibodySystem(body.mesh.comm, [body]), body


def deform(system, function):
    """State with the displacement that a function gives for positions, shapes (n, 3)."""
    state = system.initial_state()
    (block,) = system.flexible_models
    state.u[0].array[:] = function(block.positions).ravel()
    return state


def svk(F, lam=LAM, mu=MU):
    """Cauchy stress of the St. Venant-Kirchhoff material."""
    E = 0.5 * (F.T @ F - np.eye(3))
    S = lam * np.trace(E) * np.eye(3) + 2.0 * mu * E
    return F @ S @ F.T / np.linalg.det(F)


def neo_hooke(F):
    """sigma = mu/J (F F^T - I) + Lambda ln J / J I."""
    J = np.linalg.det(F)
    return (MU * (F @ F.T - np.eye(3)) + LAM * np.log(J) * np.eye(3)) / J


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize(("degree", "output"), [(1, 0), (1, 1), (2, 0), (2, 1)])
@pytest.mark.parametrize(
    ("material", "exact"),
    [
        (StVenantKirchhoff(LAM, MU), svk),
        (NeoHooke(LAM, MU), neo_hooke),
        (KelvinVoigt(StVenantKirchhoff(LAM, MU), 10.0), svk),
    ],
)
def test_homogeneous_deformation_has_the_stress_of_the_formula(
    material, exact, cell, degree, output
):
    system, body = make(material, cell, degree)
    fields = BodyFields(system, body, output)
    fields.update(deform(system, lambda X: X @ SHIFT.T))
    F = np.eye(3) + SHIFT
    sigma, E = exact(F), 0.5 * (F.T @ F - np.eye(3))
    cells = body.mesh.topology.index_map(3)
    points = 1 if output == 0 else {"tetrahedron": 4, "hexahedron": 8}[cell]
    values = fields.stress.x.array.reshape(-1, 3, 3)
    assert len(values) == points * (cells.size_local + cells.num_ghosts)
    # round-off of a sum of a few products
    assert np.allclose(values, sigma, rtol=0, atol=1e-12 * np.max(np.abs(sigma)))
    assert np.allclose(fields.strain.x.array.reshape(-1, 3, 3), E, rtol=0, atol=1e-13)
    u = fields.displacement.x.array.reshape(-1, 3)
    assert np.allclose(u, system.flexible_models[0].local_positions @ SHIFT.T, rtol=0, atol=1e-14)


def test_a_rotated_body_has_the_stress_of_the_body_at_rest_rotated():
    """The fibres of an anisotropic material turn with it."""
    law = TransverselyIsotropic(30e9, 10e9, 4e9, 0.3, 0.3, ufl.as_vector((1.0, 2.0, 0.5)))
    system, body = make(law)
    fields = BodyFields(system, body)
    stretch = np.diag([1e-3, -5e-4, 2e-3])
    fields.update(deform(system, lambda X: X @ stretch.T))
    before = fields.stress.x.array.reshape(-1, 3, 3).copy()
    a = 0.7
    R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    fields.update(deform(system, lambda X: X @ (R @ (np.eye(3) + stretch) - np.eye(3)).T))
    after = fields.stress.x.array.reshape(-1, 3, 3)
    assert np.max(np.abs(before)) > 1e6
    # strains of 1e-3 are differences of numbers of size one
    assert np.allclose(after, R @ before @ R.T, rtol=0, atol=1e-11 * np.max(np.abs(before)))


def test_norms_are_those_of_the_field_output():
    system, body = make(NeoHooke(LAM, MU))
    state = deform(system, lambda X: 0.1 * np.sin(X + np.roll(X, 1, axis=1)))
    fields = BodyFields(system, body)
    fields.update(state)
    sigma = fields.stress.x.array.reshape(-1, 3, 3)
    deviator = sigma - np.trace(sigma, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    norm, von_mises = CellCentres(system.flexible_models[0]).stresses(state.u[0])
    assert np.allclose(np.linalg.norm(sigma, axis=(1, 2)), norm, rtol=1e-12)
    mises = np.sqrt(1.5) * np.linalg.norm(deviator, axis=(1, 2))
    assert np.allclose(mises, von_mises, rtol=1e-12)


def test_moduli_may_differ_from_cell_to_cell():
    cells = box()
    moduli = cell_field(cells, lambda x: np.where(x[:, 0] < 1.0, LAM, 2.0 * LAM))
    body = FlexibleBody("body", cells, StVenantKirchhoff(moduli, MU), 1000.0)
    system = MultibodySystem(cells.comm, [body])
    fields = BodyFields(system, body)
    fields.update(deform(system, lambda X: X @ SHIFT.T))
    F = np.eye(3) + SHIFT
    for sigma, lam in zip(fields.stress.x.array.reshape(-1, 3, 3), moduli.x.array, strict=True):
        exact = svk(F, lam)
        assert np.allclose(sigma, exact, rtol=0, atol=1e-12 * np.max(np.abs(exact)))


def test_they_are_used_in_forms():
    """Power of the stress: the mean of a homogeneous field is the field."""
    system, body = make(StVenantKirchhoff(LAM, MU))
    fields = BodyFields(system, body)
    fields.update(deform(system, lambda X: X @ SHIFT.T))
    form = fem.form(ufl.tr(fields.stress) * ufl.dx)
    total = body.mesh.comm.allreduce(fem.assemble_scalar(form))
    assert total == pytest.approx(np.trace(svk(np.eye(3) + SHIFT)), rel=1e-12)  # volume 1


def test_a_body_of_another_system_is_refused():
    system, _ = make(StVenantKirchhoff(LAM, MU))
    _, other = make(StVenantKirchhoff(LAM, MU))
    with pytest.raises(ModelError, match="flexible body 'body' is not among the parts"):
        BodyFields(system, other)
