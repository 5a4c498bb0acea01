"""Numbers of cells are those that DOLFINx finds, vectorised or not."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from small_body import all_kinds, all_laws, nodal, small_body, wild

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation import vectorise
from turbine_fenicsx.materials.base import cauchy_stress
from turbine_fenicsx.materials.kinematics import deformation_gradient
from turbine_fenicsx.system.cell_centres import CellCentres
from turbine_fenicsx.system.cell_numbers import CellNumbers, CentreValues

pytestmark = pytest.mark.parallel


def interpolated_norms(model, u):
    """Norms of the stress and of its deviator in all local cells by DOLFINx' interpolation."""
    field = fem.Function(model.space)
    model.copy_to(field, u)
    sigma = cauchy_stress(model.energy, deformation_gradient(field))
    norms = [ufl.sqrt(a * ufl.inner(s, s)) for a, s in ((1.0, sigma), (1.5, ufl.dev(sigma)))]
    found = fem.Function(_compat.cellwise_space(model.body.mesh, (2,)))
    found.interpolate(_compat.expression(ufl.as_vector(norms), found.function_space))
    return found.x.array.reshape(-1, 2)


@all_kinds
@all_laws
def test_stresses_are_those_of_an_interpolation_at_the_centres(comm, caplog, cell, degree, law):
    with caplog.at_level("INFO", "turbine_fenicsx"):
        model = small_body(comm, cell, degree, law)
    assert "one by one" not in caplog.text  # all vectorised
    model.body.mesh.geometry.x[:] += 0.02 * np.sin(model.body.mesh.geometry.x[:, ::-1] * 9.0)
    for seed in (1, 2):
        u = nodal(model, wild(seed, 0.02))
        expected = interpolated_norms(model, u)  # ghosts too
        assert np.min(expected, initial=1.0) > 1e-3
        found = np.transpose(CellCentres(model).stresses(u))
        # strains of 0.1, logarithms of which have the round-off of numbers of size one
        assert np.allclose(found, expected, rtol=0, atol=1e-13 * np.max(expected, initial=0.0))


@all_kinds
def test_sums_are_those_of_the_nodal_momenta(comm, cell, degree):
    model = small_body(comm, cell, degree, "svk")
    u, v, p = nodal(model, wild(1, 0.1)), nodal(model, wild(2, 3.0)), model.new_vector()
    model.momentum(v, p)
    x, momenta = model.positions + u.array_r.reshape(-1, 3), p.array_r.reshape(-1, 3)
    angular = np.cross(x, momenta).sum(axis=0)
    expected = np.array([0.5 * (v.array_r @ p.array_r), *momenta.sum(axis=0), *angular])
    found, expected = comm.allreduce(model.integrals(u, v)[:7]), comm.allreduce(expected)
    assert found[0] > 0.1
    assert np.allclose(found, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))


def squares(comm):
    """Squares of two components of a field, of very different size, and the field."""
    cells = mesh.create_box(comm, [[0, 0, 0], [1.0, 0.5, 0.4]], [3, 2, 3], mesh.CellType.hexahedron)
    field = fem.Function(_compat.vector_space(cells, 1))
    field.interpolate(lambda x: 1.0 + np.sin(x))
    return [1e12 * field[0] ** 2, field[1] ** 2], field, cells


def test_without_lanes_numbers_are_the_same(comm, monkeypatch):
    expressions, _, cells = squares(comm)
    dx = ufl.dx(domain=cells, metadata={"quadrature_degree": 3})
    quick, quick_centres = CellNumbers(cells, (expressions, dx)), CentreValues(cells, *expressions)
    monkeypatch.setattr(
        vectorise, "_FRAME", vectorise._FRAME.replace("vector_size(", "no_such_thing(")
    )
    slow, slow_centres = CellNumbers(cells, (expressions, dx)), CentreValues(cells, *expressions)
    assert np.allclose(quick.sums(), slow.sums(), rtol=1e-13)
    assert np.allclose(quick_centres.in_cells(), slow_centres.in_cells(), rtol=1e-13)


def test_a_wrong_number_is_noticed_beside_one_that_is_much_larger(comm, monkeypatch, caplog):
    right, wrong = "A[i * BLOCK + k][l]", "(k == 1 ? -1 : 1) * A[i * BLOCK + k][l]"
    assert right in vectorise._FRAME
    monkeypatch.setattr(vectorise, "_FRAME", vectorise._FRAME.replace(right, wrong))
    expressions, field, cells = squares(comm)
    numbers = CentreValues(cells, *expressions)
    assert "please report it" in caplog.text
    field.x.array[:] = 2.0
    assert numbers.in_cells()[:, 1] == pytest.approx(4.0, rel=1e-14)
