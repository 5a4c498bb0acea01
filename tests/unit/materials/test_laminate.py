"""Claims about walls of laminates; oracle: numpy with the shape functions of the mesher."""

import numpy as np
import pytest
from dolfinx import mesh
from walls import CARBON, FOAM, GLASS, HEXAHEDRON, laminate, load_wall, wall_arrays

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import laminate_stiffness, tabulate_walls
from turbine_fenicsx.materials.wall_quadrature import wall_quadrature
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

pytestmark = pytest.mark.parallel

THICKNESS = 0.05
LAYUPS = [
    laminate((CARBON, 0.03, 30), (GLASS, 0.02, 0)),
    laminate((GLASS, 0.005, -45), (FOAM, 0.04, 0), (CARBON, 0.005, 60)),
    laminate((CARBON, 0.1, 15)),
]
H = np.array([[0.02, 0.03, -0.05], [-0.01, 0.04, 0.02], [0.06, -0.03, -0.02]])


def shell(s, a, zeta):
    """A twisted, tapered and bent piece of a tube whose wall is not normal to its surface."""
    radius = (1.0 - 0.3 * s) * (1.0 + 0.2 * a) + THICKNESS * zeta
    angle = 1.2 * a + 0.5 * s + 0.1 * zeta
    x = 2.0 * s + 0.1 * s * s + 0.02 * zeta
    return np.stack([x, radius * np.sin(angle), radius * np.cos(angle) + 0.2 * s**2], axis=-1)


@pytest.fixture(scope="module")
def wall(comm):
    arrays = wall_arrays(shell, span=2, around=3)
    loaded, number = load_wall(comm, arrays)
    return arrays, loaded.mesh, number


def layup(cell):
    return LAYUPS[cell % len(LAYUPS)]


def body(wall, moments):
    _, cells, number = wall
    table = tabulate_walls([layup(c) for c in number], np.full(len(number), THICKNESS), moments)
    law = Laminate.from_table(cells, table)
    return FlexibleBody("wall", cells, law, cell_field(cells, table.density), degree=2)


def energy_by_hand(arrays, displacement_gradient, moments):
    """Sum over the cells and Gauss points of the energy density in the axes of the wall."""
    F = np.eye(3) + displacement_gradient
    E, total = 0.5 * (F.T @ F - np.eye(3)), 0.0
    points, weights = wall_quadrature()
    gradients = HEXAHEDRON.shape_gradients(points)
    for cell, nodes in enumerate(arrays.cells):
        A = laminate_stiffness(layup(cell))[0]
        table = tabulate_walls([layup(cell)], np.array([THICKNESS]), moments)
        E3, G11, G12, G22 = table.through[0]
        for point, weight, gradient in zip(points, weights, gradients, strict=True):
            J = arrays.points[nodes].T @ gradient
            a1, normal = J[:, 0], np.cross(J[:, 0], J[:, 1])
            a1, a3 = a1 / np.linalg.norm(a1), normal / np.linalg.norm(normal)
            assert a3 @ J[:, 2] > 0.0  # outwards
            frame = np.stack([a1, np.cross(a3, a1), a3])
            e = frame @ E @ frame.T
            zeta = point[2] - 0.5
            Q = A / THICKNESS
            if moments:
                # the quadratic through three points that has the moments A, B, D
                q = table.in_plane[0].reshape(3, 6)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]]
                Q = (q[0] + zeta * q[1] + zeta**2 * q[2]).reshape(3, 3)
            plane = np.array([e[0, 0], e[1, 1], 2 * e[0, 1]])
            shear = 2 * np.array([e[0, 2], e[1, 2]])
            W = plane @ Q @ plane + E3 * e[2, 2] ** 2
            W += shear @ np.array([[G11, G12], [G12, G22]]) @ shear
            total += 0.5 * W * weight * np.linalg.det(J)
    return total


@pytest.mark.parametrize("moments", [False, True])
def test_energy_is_that_of_the_plies_in_the_axes_of_each_cell(comm, wall, moments):
    model = FlexibleModel(body(wall, moments))
    u = model.new_vector()
    u.array[:] = (model.positions @ H.T).ravel()
    found = comm.allreduce(model.strain_energy(u))
    assert isinstance(model.body.material, Material) and model.body.material.quadratic
    assert found == pytest.approx(energy_by_hand(wall[0], H, moments), rel=1e-10)
    # another order of the axes, or of the cells, is off by more than a thousandth
    for turn in (H.T, H[::-1, ::-1]):
        assert abs(energy_by_hand(wall[0], turn, moments) / found - 1) > 1e-3
    u.destroy()


def test_mass_is_that_of_the_plies(comm, wall):
    arrays, _, _ = wall
    points, weights = HEXAHEDRON.quadrature()
    gradients, mass = HEXAHEDRON.shape_gradients(points), 0.0
    for cell, nodes in enumerate(arrays.cells):
        J = np.einsum("ni,pnj->pij", arrays.points[nodes], gradients)
        per_area = sum(ply.thickness * ply.material.density for ply in layup(cell))
        mass += per_area / THICKNESS * np.sum(weights * np.linalg.det(J))
    found = comm.allreduce(FlexibleModel(body(wall, False)).nodal_mass.sum())
    assert found == pytest.approx(mass, rel=1e-12)


def test_rigid_motion_has_no_energy_and_no_force(comm, wall):
    model = FlexibleModel(body(wall, True))
    u, f = model.new_vector(), model.new_vector()
    c, s = np.cos(2.0), np.sin(2.0)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    u.array[:] = (model.positions @ (R - np.eye(3)).T + [1.0, -2.0, 0.5]).ravel()
    model.static_forces(u, np.zeros(3), 0.0, f)
    # round-off of the strains is 1e-15, of moduli of 1e11 Pa over areas of 0.1 m^2, on some nodes
    assert f.norm() < 1e-2
    assert comm.allreduce(model.strain_energy(u)) < 1e-12
    u.destroy()
    f.destroy()


@pytest.mark.parametrize("linear_solver", ["frozen", "lu"])
def test_a_spinning_wall_keeps_energy_and_momentum(comm, wall, linear_solver):
    """Energy and stress are sampled at the same points."""
    spin = np.array([3.0, -20.0, 40.0])
    still = body(wall, True)

    def velocity(X):
        return np.cross(spin, X) + 30.0 * X[:, [1, 2, 0]] ** 2

    free = FlexibleBody("wall", still.mesh, still.material, still.density, 2, velocity=velocity)
    system = MultibodySystem(comm, [free])
    first = system.balance(system.initial_state())
    options = SolverOptions(linear_solver=linear_solver)
    stepper = EnergyMomentum(system, options=options)
    last = Simulation(system, 2e-3, 0.02, stepper=stepper).run()
    stepper.destroy()
    assert last.balance.strain > 1e-3 * first.kinetic
    assert abs(last.energy_error) < 1e-10 * first.kinetic
    assert np.allclose(last.balance.angular, first.angular, rtol=1e-10)


def test_fields_of_another_size_are_refused(wall):
    _, cells, number = wall
    four, five = (cell_field(cells, np.ones((len(number), k))) for k in (4, 5))
    with pytest.raises(ModelError, match=r"6 or 18 components .* got shapes \(5,\) and \(4,\)"):
        Laminate(five, four)


def test_other_cells_are_refused(comm):
    """Tetrahedra have no axes along span and thickness."""
    cells = mesh.create_box(comm, [[0, 0, 0], [1, 1, 1]], [1, 1, 1], mesh.CellType.tetrahedron)
    six, four = (cell_field(cells, lambda X, k=k: np.ones((len(X), k))) for k in (6, 4))
    with pytest.raises(ModelError, match="quadrilaterals, got tetrahedron"):
        Laminate(six, four)
