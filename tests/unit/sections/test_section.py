"""Claims about cross-sections: closed forms, thin walls, published matrices, stress."""

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx import mesh as meshes
from section_meshes import loops, rectangle, ring, wall_ring

import turbine_fenicsx as tf
from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.section_matrices import move_stiffness
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import laminate_stiffness, tabulate_walls
from turbine_fenicsx.materials.ply import Ply, PlyMaterial

E, NU = 100.0, 0.2
G = E / (2.0 * (1.0 + NU))


def isotropic(E=E, nu=NU):
    return tf.StVenantKirchhoff(E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu)))


def rotated(angle):
    """The orthotropic material of BECAS's user guide, its fibres turned from z to x."""
    c, s = np.cos(angle), np.sin(angle)
    frame = [ufl.as_vector(a) for a in ((s, 0.0, c), (c, 0.0, -s), (0.0, 1.0, 0.0))]
    return tf.OrthotropicSVK(
        young=(480.0, 120.0, 120.0),
        shear=(60.0, 50.0, 60.0),
        poisson=(0.19, 0.26, 0.19),
        frame=tuple(frame),
    )


def test_an_ellipse_has_its_closed_forms():
    a, b = 0.3, 0.1
    angle = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
    circle = np.column_stack([a * np.cos(angle), b * np.sin(angle)])
    section = tf.analyse_section(ring([1e-4 * circle, 0.5 * circle, circle]), isotropic())
    area = np.pi * a * b
    found = np.diag(section.stiffness)[2:]
    J = np.pi * a**3 * b**3 / (a * a + b * b)
    expected = [E * area, E * area * b * b / 4.0, E * area * a * a / 4.0, G * J]
    assert found == pytest.approx(expected, rel=2e-3)  # a polygon of 96 sides
    off = section.stiffness - np.diag(np.diag(section.stiffness))
    assert np.abs(off).max() < 1e-9 * E * area


@pytest.mark.parametrize("in_space", [True, False])
def test_a_rectangle_has_its_closed_forms(in_space):
    w, h = 0.2, 0.1
    section = tf.analyse_section(rectangle(w, h, 8, 6, in_space), isotropic(nu=0.0), 3.0)
    odd = np.arange(1, 40, 2)
    series = 1.0 - 192.0 * h / (np.pi**5 * w) * np.sum(np.tanh(odd * np.pi * w / (2 * h)) / odd**5)
    A, J = w * h, w * h**3 / 3.0 * series
    shear = 5.0 / 6.0 * E / 2.0 * A
    expected = [shear, shear, E * A, E * A * h * h / 12.0, E * A * w * w / 12.0, E / 2.0 * J]
    assert np.diag(section.stiffness) == pytest.approx(expected, rel=5e-4)
    assert section.mass == pytest.approx(3.0 * A, rel=1e-12)
    rho_xx, rho_yy = 3.0 * A * w * w / 12.0, 3.0 * A * h * h / 12.0
    assert np.diag(section.inertia)[3:] == pytest.approx([rho_yy, rho_xx, rho_xx + rho_yy])


def test_squares_of_becas_come_out_to_its_last_digit():
    """BECAS user guide, cases S1 and S3: bilinear elements, 10 x 10."""
    square = rectangle(0.1, 0.1, 10, 10, True)

    def diagonal(material):
        return np.diag(tf.analyse_section(square, material, degree=1).stiffness)

    expected = [3.4899e-1, 3.4899e-1, 1.0, 8.3384e-4, 8.3384e-4, 5.9084e-4]
    assert diagonal(isotropic()) == pytest.approx(expected, rel=2e-5)
    expected = [5.039e-1, 4.201e-1, 4.8, 4.001e-3, 4.001e-3, 7.737e-4]
    assert diagonal(rotated(0.0)) == pytest.approx(expected, rel=3e-4)
    expected = [5.0202e-1, 5.0406e-1, 1.2, 1.0004e-3, 1.0002e-3, 8.5081e-4]
    assert diagonal(rotated(np.pi / 2.0)) == pytest.approx(expected, rel=3e-4)
    K = tf.analyse_section(square, rotated(np.pi / 8.0), degree=1).stiffness
    expected = [7.598e-1, 4.129e-1, 3.435, 2.489e-3, 2.274e-3, 9.499e-4]
    assert np.diag(K) == pytest.approx(expected, rel=3e-4)
    assert [K[0, 2], K[3, 5]] == pytest.approx([7.387e-1, -4.613e-4], rel=3e-4)


def test_an_open_section_has_its_shear_centre_outside():
    """BECAS user guide, case C2: half a tube."""
    angle = np.linspace(np.pi / 2.0, 1.5 * np.pi, 31)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    section = tf.analyse_section(ring([0.09 * arc, 0.1 * arc], closed=False), isotropic())
    expected = [4.964e-2, 6.244e-2, 2.982e-1, 1.349e-3, 1.349e-3, 9.120e-4]
    K = section.stiffness
    assert np.diag(K) == pytest.approx(expected, rel=3e-3)
    assert [K[2, 4], K[1, 5]] == pytest.approx([1.805e-2, -7.529e-3], rel=3e-3)
    assert section.shear_centre == pytest.approx([-0.1206, 0.0], abs=3e-4)
    assert section.tension_centre == pytest.approx([-0.06051, 0.0], abs=1e-4)
    assert section.mass_centre == pytest.approx(section.tension_centre, abs=1e-9)


def test_two_thin_cells_share_the_torsion_as_bredt_and_batho_say():
    """Cells of 0.6 x 0.4 and 0.4 x 0.4 m between the middles of walls of 4 mm."""
    w1, w2, h, t = 0.6, 0.4, 0.4, 0.004
    J = tf.analyse_section(loops(w1, w2, h, t), isotropic()).torsion_stiffness / G
    # A_i (two areas) = flexibility of the walls times the flows of unit rate of twist
    walls = np.array([[2 * w1 + 2 * h, -h], [-h, 2 * w2 + 2 * h]]) / t
    areas = 2.0 * np.array([w1 * h, w2 * h])
    thin = areas @ np.linalg.solve(walls, areas)
    assert J == pytest.approx(thin, rel=5e-3)


def test_a_pipe_of_two_layers_has_the_couplings_of_vabs():
    """W. Yu et al., VABS: walls [0, 90], half circles [-45, 45] from the outside, in inches."""
    flat, half = np.linspace(-1.0, 1.0, 13)[:-1], np.linspace(0.5, -0.5, 25)[:-1] * np.pi

    def loop(r):
        top = np.column_stack([flat, np.full(12, r)])
        right = np.column_stack([1.0 + r * np.cos(half), r * np.sin(half)])
        return np.concatenate([top, right, -top, -right])[::-1]

    mesh = ring([loop(r) for r in (0.3, 0.4, 0.5)])

    def find_axes(X):
        """Fibre, and two directions across, in the middle of each cell."""
        centre = np.column_stack([np.clip(X[:, 0], -1.0, 1.0), 0.0 * X[:, 0], 0.0 * X[:, 0]])
        out = X - centre
        is_outer = np.linalg.norm(out, axis=1) > 0.4
        out /= np.linalg.norm(out, axis=1)[:, None]
        flat = np.abs(X[:, 0]) < 1.0
        angle = np.where(flat, np.where(is_outer, 0.0, 90.0), np.where(is_outer, -45.0, 45.0))
        c, s = np.cos(np.radians(angle))[:, None], np.sin(np.radians(angle))[:, None]
        span = np.array([0.0, 0.0, 1.0])
        around = np.cross(out, span)
        return np.column_stack([c * span + s * around, c * around - s * span, -out])

    axes = cell_field(mesh, find_axes)
    frame = tuple(ufl.as_vector([axes[3 * k + i] for i in range(3)]) for k in range(3))
    E, G, nu = (20.59e6, 1.42e6, 1.42e6), (0.87e6,) * 3, (0.42,) * 3
    material = tf.OrthotropicSVK(young=E, shear=G, poisson=nu, frame=frame)
    K = tf.analyse_section(mesh, material).stiffness
    expected = [7.85310e5, 3.29279e5, 1.03892e7, 1.88238e6, 5.38987e6, 6.87275e5]
    assert np.diag(K) == pytest.approx(expected, rel=0.01)
    expected = [9.84575e4, -8.21805e3, -5.20981e4]
    assert [K[2, 5], K[0, 3], K[1, 4]] == pytest.approx(expected, rel=0.02)


def test_matrices_move_and_turn_with_the_section():
    shift, angle = np.array([0.03, -0.05]), 0.4
    c, s = np.cos(angle), np.sin(angle)
    mesh = rectangle(0.2, 0.1, 6, 4, True)
    first = tf.analyse_section(mesh, isotropic())
    mesh.geometry.x[:, :2] = mesh.geometry.x[:, :2] @ [[c, s], [-s, c]] + shift
    second = tf.analyse_section(mesh, isotropic())
    place = [np.array([x]) for x in (*shift, angle)]
    expected = move_stiffness(first.stiffness[None], *place)[0]
    assert second.stiffness == pytest.approx(expected, rel=1e-8, abs=1e-10 * E)
    for centre in second.tension_centre, second.shear_centre, second.mass_centre:
        assert centre == pytest.approx(shift, abs=1e-9)
    (low, high), direction = second.bending
    assert [low, high] == pytest.approx(np.diag(first.stiffness)[3:5], rel=1e-8)
    assert direction == pytest.approx(angle, abs=1e-8)


def test_stress_has_the_loads_as_its_resultants():
    """In a section of two materials."""
    mesh = rectangle(0.2, 0.1, 6, 4, True)
    stiff = cell_field(mesh, lambda X: np.where(X[:, 0] < 0.0, 28.0, 84.0))
    section = tf.analyse_section(mesh, tf.StVenantKirchhoff(stiff, stiff))
    loads = np.array([2.0, -3.0, 5.0, 0.3, -0.2, 0.1])
    sigma = section.stress(loads)
    x = ufl.SpatialCoordinate(mesh)
    traction = [sigma[i, 2] for i in range(3)]
    moments = [x[1] * traction[2], -x[0] * traction[2], x[0] * traction[1] - x[1] * traction[0]]
    dx = ufl.dx(metadata={"quadrature_degree": 4})
    found = [fem.assemble_scalar(_compat.compile_form(t * dx)) for t in (*traction, *moments)]
    assert found == pytest.approx(loads, rel=1e-6, abs=1e-6)
    assert section.shear_centre[0] > section.mass_centre[0] + 0.01


def test_stress_of_a_rectangle_is_that_of_the_beam():
    w, h = 0.2, 0.1
    section = tf.analyse_section(rectangle(w, h, 6, 4, True), isotropic(nu=0.0))
    sigma = section.stress([0.0, 0.0, 0.0, 7.0, 0.0, 0.0])
    X = sigma.function_space.tabulate_dof_coordinates()
    values = sigma.x.array.reshape(-1, 3, 3)
    assert values[:, 2, 2] == pytest.approx(7.0 * X[:, 1] / (w * h**3 / 12.0), abs=1e-6)
    sigma = section.stress([0.0, 4.0, 0.0, 0.0, 0.0, 0.0])
    values = sigma.x.array.reshape(-1, 3, 3)
    parabola = 1.5 * 4.0 / (w * h) * (1.0 - (2.0 * X[:, 1] / h) ** 2)
    assert values[:, 1, 2] == pytest.approx(parabola, abs=0.1 * 4.0 / (w * h))  # straight in cells


def test_a_law_that_is_not_quadratic_counts_at_rest():
    mesh = rectangle(0.2, 0.1, 4, 4, True)
    found = tf.analyse_section(mesh, tf.NeoHooke(27.0, 41.0)).stiffness
    expected = tf.analyse_section(mesh, tf.StVenantKirchhoff(27.0, 41.0)).stiffness
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_what_is_no_section_is_refused_in_a_sentence():
    cube = meshes.create_unit_cube(MPI.COMM_SELF, 1, 1, 1)
    flat = rectangle(0.2, 0.1, 2, 2, True)
    tilted = rectangle(0.2, 0.1, 2, 2, True)
    tilted.geometry.x[:, 2] = 0.5 * tilted.geometry.x[:, 0]
    apart = loops(0.6, 0.4, 0.4, 0.004, apart=True)
    for mesh, options, words in [
        (cube, {}, "triangles or quadrilaterals"),
        (tilted, {}, "plane of one z"),
        (apart, {}, "hang together"),
        (flat, {"degree": 0}, "degree of a section"),
        (flat, {"density": 0.0}, "mass of a section must be positive"),
    ]:
        with pytest.raises(tf.ModelError, match=words):
            tf.analyse_section(mesh, isotropic(), **options)
    with pytest.raises(tf.ModelError, match="loads of a section"):
        tf.analyse_section(flat, isotropic()).stress([1.0, 2.0])


@pytest.mark.parallel
def test_a_distributed_section_is_refused():
    if MPI.COMM_WORLD.size == 1:
        pytest.skip("needs two ranks")
    mesh = meshes.create_unit_square(MPI.COMM_WORLD, 4, 4)
    with pytest.raises(tf.ModelError, match="mesh of one rank"):
        tf.analyse_section(mesh, isotropic())


def test_a_tube_of_plies_is_that_of_lamination_theory():
    """Walls as one quadratic cell: plies at 0 and +-45 degrees, about their middle."""
    R, t = 0.5, 0.01
    ply = PlyMaterial("ply", 1500.0, (40e9, 10e9, 10e9), (4e9, 4e9, 3.5e9), (0.28, 0.28, 0.4))
    angles = np.radians([45.0, -45.0, 0.0, 0.0, -45.0, 45.0])
    plies = tuple(Ply(ply, t / 6.0, angle) for angle in angles)
    mesh = wall_ring(R - t / 2.0, R + t / 2.0, 24)
    table = tabulate_walls([plies] * 24, np.full(24, t), moments=True)
    density = cell_field(mesh, table.density)
    section = tf.analyse_section(mesh, Laminate.from_table(mesh, table), density)
    soft = np.linalg.inv(laminate_stiffness(plies)[0])  # free around the section
    girth = 2.0 * np.pi * R
    expected = [
        girth / soft[0, 0],
        *2 * [girth * R**2 / 2.0 / soft[0, 0]],
        girth * R**2 / soft[2, 2],
    ]
    assert np.diag(section.stiffness)[2:] == pytest.approx(expected, rel=2e-3)
    assert section.mass == pytest.approx(1500.0 * girth * t, rel=1e-4)
