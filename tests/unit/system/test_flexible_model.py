"""Claims about a flexible body without a time step, for all laws, cells and degrees."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import fem, mesh
from small_body import (
    EPS,
    FRAME,
    GRAVITY,
    LAMBDA,
    MASS,
    MU,
    SIZE,
    affine,
    all_kinds,
    all_laws,
    energy,
    kinetic,
    nodal,
    small_body,
    total,
    wild,
)

from turbine_fenicsx import NodeForce, Pressure, Ramp
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.cell_centres import CellCentres


@pytest.fixture(scope="module")
def make():
    """Models by cell, degree and law, each made once."""
    made = {}

    def block(*key, comm=MPI.COMM_WORLD):
        if (comm.size, *key) not in made:
            made[comm.size, *key] = small_body(comm, *key)
        return made[comm.size, *key]

    return block


@all_kinds
@all_laws
def test_strain_energy_is_frame_invariant(make, cell, degree, law):
    model = make(cell, degree, law)
    u, Q = nodal(model, wild(11, 0.02)), rotation_about((1, 2, 0.5), 2.5)
    turned = model.new_vector()
    x = model.positions + u.array_r.reshape(-1, 3)
    turned.array[:] = (x @ Q.T + [1.0, -2.0, 0.5] - model.positions).ravel()
    W = energy(model, u)
    assert W > 1e-3
    assert energy(model, turned) == pytest.approx(W, abs=200 * EPS * 20)  # moduli of 20


@pytest.mark.parallel
@all_kinds
def test_nodal_mass_adds_up_to_density_times_volume(make, cell, degree):
    model = make(cell, degree, "svk")
    assert total(model, model.nodal_mass) == pytest.approx(MASS, rel=1e-14)
    centre = total(model, model.nodal_mass[:, None] * model.positions) / MASS
    assert np.allclose(centre, SIZE / 2, rtol=0, atol=1e-14)


@pytest.mark.parallel
@all_kinds
def test_momenta_and_kinetic_energy_of_a_turning_block_equal_those_of_a_rigid_one(
    make, cell, degree
):
    """Inertia is integrated exactly, so that J is that of the cuboid."""
    model = make(cell, degree, "svk")
    c, w = np.array([1.0, -2.0, 0.5]), np.array([0.3, -1.0, 0.7])
    v = nodal(model, lambda X: c + np.cross(w, X))
    p = model.new_vector()
    model.momentum(v, p)
    momenta = p.array_r.reshape(-1, 3)
    m, x = MASS, SIZE / 2
    J = m / 12 * np.diag(np.sum(SIZE**2) - SIZE**2)
    V = c + np.cross(w, x)
    assert np.allclose(total(model, momenta), m * V, rtol=1e-13, atol=0)
    L = total(model, np.cross(model.positions, momenta))
    assert np.allclose(L, np.cross(x, m * V) + J @ w, rtol=0, atol=1e-13)
    assert kinetic(model, v) == pytest.approx(0.5 * m * V @ V + 0.5 * w @ J @ w, rel=1e-13)


STRETCH = np.diag([1.1, 0.97, 1.02])


def cauchy_by_hand(law):
    C = STRETCH @ STRETCH
    J = np.linalg.det(STRETCH)
    if law == "svk":
        E = 0.5 * (C - np.eye(3))
        S = LAMBDA * np.trace(E) * np.eye(3) + 2 * MU * E
    else:
        inverse = np.linalg.inv(C)
        S = MU * (np.eye(3) - inverse) + LAMBDA * np.log(J) * inverse
    return STRETCH @ S @ STRETCH / J


@all_kinds
@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_cauchy_stress_norm_of_a_uniform_stretch_equals_the_hand_value(make, cell, degree, law):
    model = make(cell, degree, law)
    Q = rotation_about((1, 2, 0.5), 2.5)
    norm = CellCentres(model).stresses(nodal(model, affine(Q @ STRETCH - np.eye(3))))[0]
    cells = model.body.mesh.topology.index_map(3)
    assert norm.shape == (cells.size_local + cells.num_ghosts,)
    assert np.allclose(norm, np.linalg.norm(cauchy_by_hand(law)), rtol=1e-12, atol=0)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_von_mises_stress_of_a_uniform_stretch_equals_the_hand_value(make, law):
    model = make("hexahedron", 1, law)
    _, found = CellCentres(model).stresses(nodal(model, affine(STRETCH - np.eye(3))))
    s = cauchy_by_hand(law)
    shear = s[0, 1] ** 2 + s[1, 2] ** 2 + s[2, 0] ** 2
    normal = (s[0, 0] - s[1, 1]) ** 2 + (s[1, 1] - s[2, 2]) ** 2 + (s[2, 2] - s[0, 0]) ** 2
    assert np.allclose(found, np.sqrt(0.5 * normal + 3.0 * shear), rtol=1e-12, atol=0)


@all_kinds
def test_strain_energy_of_a_uniform_stretch_equals_the_hand_value(make, cell, degree):
    model = make(cell, degree, "svk")
    E = 0.5 * (STRETCH @ STRETCH - np.eye(3))
    W = 0.5 * LAMBDA * np.trace(E) ** 2 + MU * np.sum(E * E)
    u = nodal(model, affine(STRETCH - np.eye(3)))
    assert energy(model, u) == pytest.approx(W * np.prod(SIZE), rel=1e-12)


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
def test_fibres_turn_with_the_body(comm, cell, degree):
    model = small_body(comm, cell, degree, "orthotropic", fibre=True)
    F = rotation_about((1, 2, 0.5), 2.5) @ STRETCH
    directions = CellCentres(model).fibres(nodal(model, affine(F - np.eye(3))))
    cells = model.body.mesh.topology.index_map(3)
    assert directions.shape == (cells.size_local + cells.num_ghosts, 3)
    expected = F @ FRAME[:, 0] / np.linalg.norm(F @ FRAME[:, 0])
    assert np.allclose(directions, expected, rtol=0, atol=1e-13)


def test_a_body_without_fibres_has_no_fibre_directions(make):
    model = make("hexahedron", 1, "svk")
    assert CellCentres(model).fibres(model.new_vector()) is None


@pytest.mark.parallel
@all_kinds
def test_nodal_values_come_with_ghosts(make, cell, degree):
    model = make(cell, degree, "svk")
    f = fem.Function(model.space)
    f.interpolate(lambda x: np.array([x[0], 2 * x[1], x[2] - x[0]]))
    X = nodal(model, affine([[1, 0, 0], [0, 2, 0], [-1, 0, 1]]))
    assert np.allclose(model.nodal_values(X).ravel(), f.x.array, rtol=0, atol=1e-14)


def loads(body):
    """A pressure that follows the end, and a force on a corner."""
    end = mesh.locate_entities_boundary(body.mesh, 2, lambda x: np.isclose(x[0], SIZE[0]))
    pressure = Pressure("p", body, end, 0.7, Ramp(1.0, 1.0))
    return [
        pressure,
        NodeForce("f", body, point=SIZE, force=(0.1, -0.3, 0.2), function=Ramp(2.0, 1.0)),
    ]


@pytest.fixture(scope="module")
def make_loaded():
    """Loaded models by cell, degree and law, each made once."""
    made = {}

    def model(*key):
        if key not in made:
            made[key] = small_body(MPI.COMM_WORLD, *key, make_loads=loads)
        return made[key]

    return model


@pytest.mark.parallel
@all_kinds
@all_laws
def test_stiffness_is_the_derivative_of_the_forces_at_rest(make_loaded, cell, degree, law):
    """Also that of a pressure that follows; by central differences, so up to h^2."""
    model, h, time = make_loaded(cell, degree, law), 1e-6, 0.6
    u, w = nodal(model, wild(1, 0.02)), nodal(model, wild(2, 1.0))
    K, exact = model.new_stiffness(), model.new_vector()
    model.assemble_stiffness(u, time, K)
    K.mult(w, exact)
    ends = [model.new_vector() for _ in range(2)]
    for sign, out in zip((1, -1), ends, strict=True):
        model.static_forces(u + sign * h * w, GRAVITY, time, out)
    difference = (ends[0] - ends[1]) * (0.5 / h)
    # h^2 times third derivatives, which the short waves (strains of 60 h) make large
    assert (difference - exact).norm() <= 2e-7 * exact.norm()
    K.destroy()


def test_a_pressure_that_follows_is_part_of_the_stiffness(make, make_loaded):
    """What the test above tells apart: without loads K is symmetric, and another."""
    asymmetries = []
    for model in (make("hexahedron", 1, "svk"), make_loaded("hexahedron", 1, "svk")):
        u, v, w = (nodal(model, wild(k, s)) for k, s in ((1, 0.02), (2, 1.0), (3, 1.0)))
        K, Kv, Kw = model.new_stiffness(), model.new_vector(), model.new_vector()
        model.assemble_stiffness(u, 1.0, K)
        K.mult(v, Kv)
        K.mult(w, Kw)
        asymmetries.append(abs(w.dot(Kv) - v.dot(Kw)) / (w.norm() * Kv.norm()))
        K.destroy()
    assert asymmetries[0] <= 1e-14
    assert asymmetries[1] > 1e-4


@all_kinds
def test_forces_at_rest_are_the_loads_in_a_body_that_is_not_strained(make_loaded, cell, degree):
    """Weight, the pressure on the end, and the force on the corner, at a half of its ramp."""
    model = make_loaded(cell, degree, "svk")
    out = model.new_vector()
    model.static_forces(model.new_vector(), GRAVITY, 0.5, out)
    weight = MASS * GRAVITY
    pressure = 0.5 * 0.7 * SIZE[1] * SIZE[2] * np.array([-1.0, 0.0, 0.0])
    corner = Ramp(2.0, 1.0)(0.5) * np.array([0.1, -0.3, 0.2])
    expected = -(weight + pressure + corner)
    found = total(model, out.array_r.reshape(-1, 3))
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-13)


@all_kinds
@all_laws
def test_forces_at_rest_are_the_slope_of_the_strain_energy(make, cell, degree, law):
    model, h = make(cell, degree, law), 1e-6
    u, w = nodal(model, wild(3, 0.02)), nodal(model, wild(4, 1.0))
    out = model.new_vector()
    model.static_forces(u, np.zeros(3), 0.0, out)
    slope = (energy(model, u + h * w) - energy(model, u - h * w)) / (2 * h)
    assert w.dot(out) == pytest.approx(slope, rel=1e-6, abs=1e-8)


@all_kinds
def test_the_mass_matrix_makes_momenta_of_velocities(make, cell, degree):
    model = make(cell, degree, "svk")
    M, v = model.mass_matrix(), nodal(model, wild(5, 1.0))
    by_matrix, by_form = model.new_vector(), model.new_vector()
    M.mult(v, by_matrix)
    model.momentum(v, by_form)
    assert by_form.norm() > 1e-3
    assert (by_matrix - by_form).norm() <= 1e-13 * by_form.norm()
    M.destroy()


def test_masses_with_a_tensor_are_added_to_a_stiffness(make):
    model = make("hexahedron", 1, "svk")
    A = np.array([[2.0, -1.0, 0.5], [-1.0, 3.0, 0.0], [0.5, 0.0, 1.0]])
    u, v = nodal(model, wild(5, 0.01)), nodal(model, wild(6, 1.0))
    K, M = model.new_stiffness(), model.mass_matrix(A)
    model.assemble_stiffness(u, 0.0, K)
    wanted, found = model.new_vector(), model.new_vector()
    K.mult(v, wanted)
    M.multAdd(v, wanted, wanted)
    model.add_mass(A, K)
    K.mult(v, found)
    assert (found - wanted).norm() <= 1e-13 * wanted.norm()
    model.assemble_stiffness(u, 0.0, K)
    K.mult(v, found)
    assert (found - wanted).norm() > 1e-6 * wanted.norm()
    K.destroy()
    M.destroy()
