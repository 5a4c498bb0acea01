"""A vectorised linear form is the one that DOLFINx assembles, up to round-off."""

import warnings

from petsc4py import PETSc

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from small_body import all_kinds

from turbine_fenicsx import NeoHooke, StVenantKirchhoff, _compat, cell_field
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation import vectorise
from turbine_fenicsx.foundation.form_cache import describe_processors
from turbine_fenicsx.materials.kinematics import deformation_gradient, right_cauchy_green
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.linear_form import LinearForm
from turbine_fenicsx.time_stepping.discrete_gradients import discrete_gradient_stress

pytestmark = pytest.mark.parallel

ROUND_OFF = {"svk": 1e-13, "neo_hooke": 1e-10}
"""Relative to the largest: sums of some hundred products; and Gonzalez' correction, which divides
the round-off of energies by increments dC of which some are hardly larger than 2e-3."""


def crooked(comm, cell, n):
    """A box of cells that are no parallelepipeds; 18 do not fill registers of four or eight."""
    cells = mesh.create_box(comm, [[0, 0, 0], [1.0, 0.5, 0.4]], n, getattr(mesh.CellType, cell))
    X = cells.geometry.x
    X[:] += 0.02 * np.sin(X @ np.array([[7.0, 3, 2], [1, 8, 3], [2, 4, 9]]))
    return cells


def body_form(comm, cell, degree, law, n=(3, 2, 3)):
    """Inertia and stress of a step, with a field of densities, and what may change in it."""
    cells = crooked(comm, cell, n)
    material = {"svk": StVenantKirchhoff, "neo_hooke": NeoHooke}[law](6.0, 4.0)
    rho = cell_field(cells, lambda X: 1.0 + X[:, 0])
    model = FlexibleModel(FlexibleBody("b", cells, material, rho, degree))
    u, du = (fem.Function(model.space) for _ in range(2))
    g = fem.Constant(cells, np.array([1.0, 2.0, 3.0]))
    w = ufl.TestFunction(model.space)
    F = deformation_gradient(u + 0.5 * du)
    S = discrete_gradient_stress(material.quadratic)(model.energy, F, ufl.grad(du))
    form = model.density * ufl.dot(du - g, w) * model.dx_mass
    form += ufl.inner(F * S, ufl.grad(w)) * model.dx_stress
    return model, form, (u, du, g)


def fill(fields, seed):
    """Waves that are functions of the position, so that ranks agree."""
    u, du, g = fields
    K = np.random.default_rng(seed).uniform(2, 9, (3, 3))
    for field in (u, du):
        field.interpolate(lambda X: 0.03 * np.sin(K @ X))
    g.value[:] = K[0]


def both(model, made, form):
    """What a form assembles to, and what DOLFINx assembles."""
    found, expected = model.new_vector(), model.new_vector()
    model.assemble(made, found)
    model.assemble(_compat.compile_form(form), expected)
    return found.array, expected.array, expected.norm(PETSc.NormType.NORM_INFINITY)


def available():
    """Registers that this processor has."""
    return range(vectorise.find_registers(describe_processors()), len(vectorise.REGISTERS))


@all_kinds
@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_lanes_give_what_dolfinx_gives_also_when_fields_change(comm, cell, degree, law):
    model, form, fields = body_form(comm, cell, degree, law)
    made = LinearForm(form)
    assert made.is_vectorised
    for seed in (1, 2):
        fill(fields, seed)
        found, expected, size = both(model, made, form)
        assert size > 0.1
        assert found == pytest.approx(expected, abs=ROUND_OFF[law] * size)


def test_nodes_of_cells_are_found_without_a_warning_of_any_release(comm):
    cells = crooked(comm, "hexahedron", (2, 1, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        nodes = _compat.nodes_of_cells(cells)
    assert nodes.shape[1] == 8 and nodes.dtype == np.int32


@pytest.mark.parametrize("registers", available())
def test_registers_of_all_widths_give_the_same(comm, monkeypatch, registers):
    monkeypatch.setattr(vectorise, "find_registers", lambda processors: registers)
    model, form, fields = body_form(comm, "hexahedron", 1, "neo_hooke")
    fill(fields, 3)
    found, expected, size = both(model, LinearForm(form), form)
    assert found == pytest.approx(expected, abs=ROUND_OFF["neo_hooke"] * size)


def test_one_cell_fills_no_register_and_leaves_ranks_without_cells(comm):
    model, form, fields = body_form(comm, "hexahedron", 1, "svk", n=(1, 1, 1))
    fill(fields, 6)
    found, expected, size = both(model, LinearForm(form), form)
    assert size > 0.01
    assert found == pytest.approx(expected, abs=ROUND_OFF["svk"] * size)


def test_surfaces_and_parts_of_the_cells_are_left_to_dolfinx(comm):
    model, form, fields = body_form(comm, "hexahedron", 1, "svk")
    fill(fields, 4)
    cells, w = model.body.mesh, ufl.TestFunction(model.space)
    N = ufl.FacetNormal(cells)
    form += ufl.dot(N, w) * ufl.ds(domain=cells)
    made = LinearForm(form)
    assert made.is_vectorised
    found, expected, size = both(model, made, form)
    assert found == pytest.approx(expected, abs=ROUND_OFF["svk"] * size)
    n = cells.topology.index_map(3).size_local
    tags = mesh.meshtags(cells, 3, np.arange(n, dtype=np.int32), np.arange(n, dtype=np.int32) % 2)
    dx = ufl.Measure("dx", domain=cells, subdomain_data=tags)
    form = ufl.dot(fields[0], w) * dx(1)
    made = LinearForm(form)
    assert not made.is_vectorised
    found, expected, size = both(model, made, form)
    assert found == pytest.approx(expected, abs=ROUND_OFF["svk"] * size)


def test_a_kernel_that_is_not_understood_is_left_to_dolfinx(comm, caplog):
    model, _, (u, *_) = body_form(comm, "tetrahedron", 1, "svk")
    form = ufl.dot(ufl.erf(u[0]) * u, ufl.TestFunction(model.space)) * model.dx_mass
    with caplog.at_level("INFO", "turbine_fenicsx"):
        made = LinearForm(form)
    assert not made.is_vectorised and "erf" in caplog.text
    u.interpolate(lambda X: np.sin(X))
    found, expected, size = both(model, made, form)
    assert size > 0 and np.array_equal(found, expected)


def test_a_compiler_without_registers_is_left_to_dolfinx(comm, monkeypatch):
    monkeypatch.setattr(
        vectorise, "_FRAME", vectorise._FRAME.replace("vector_size(", "no_such_thing(")
    )
    model, form, fields = body_form(comm, "tetrahedron", 1, "svk")
    fill(fields, 5)
    made = LinearForm(form)
    assert not made.is_vectorised
    found, expected, _ = both(model, made, form)
    assert np.array_equal(found, expected)


def test_lanes_that_compute_something_else_are_noticed_and_left_to_dolfinx(
    comm, monkeypatch, caplog
):
    """As if a future FFCx wrote something that is understood in a wrong way."""
    right = vectorise.vectorise_kernel
    monkeypatch.setattr(
        vectorise, "vectorise_kernel", lambda body: right(body).replace("+=", "-=", 1)
    )
    model, form, fields = body_form(comm, "hexahedron", 1, "svk")
    fill(fields, 6)
    before = [np.copy(field.x.array) for field in fields[:2]]
    made = LinearForm(form)
    assert not made.is_vectorised and "please report it" in caplog.text
    assert all(np.array_equal(f.x.array, x) for f, x in zip(fields, before, strict=False))
    found, expected, _ = both(model, made, form)
    assert np.array_equal(found, expected)


@all_kinds
@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_strain_energy_of_the_nodes_adds_up_to_the_integral(comm, cell, degree, law):
    model, _, fields = body_form(comm, cell, degree, law)
    fill(fields, 3)
    u = model.new_vector()
    u.array[:] = fields[0].x.array[: 3 * model.n_owned]
    energy = model.energy(right_cauchy_green(deformation_gradient(fields[0]))) * model.dx_stress
    expected = comm.allreduce(fem.assemble_scalar(_compat.compile_form(energy)))
    assert expected > 1e-3
    assert abs(comm.allreduce(model.strain_energy(u)) - expected) <= 1e-13 * expected
