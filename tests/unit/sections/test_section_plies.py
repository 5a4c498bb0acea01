"""Claims about plies in sections: those of solids and of lamination theory."""

from mpi4py import MPI

import numpy as np
import pytest
from section_meshes import GMSH_ORDER, rectangle, wall_ring
from walls import CARBON, FOAM, GLASS, laminate, load_wall, wall_arrays

import turbine_fenicsx as tf
from turbine_fenicsx import _compat
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import (
    laminate_stiffness,
    tabulate_walls,
    total_thickness,
)
from turbine_fenicsx.materials.ply_failure import maximum_strain
from turbine_fenicsx.sections.section_plies import SectionPlies
from turbine_fenicsx.system.ply_stresses import PlyStresses

AROUND = 10
LAYUPS = (
    laminate((GLASS, 0.004, 45), (FOAM, 0.012, 0), (CARBON, 0.004, 10)),
    laminate((CARBON, 0.02, -30)),
)


def loop(a, zeta):
    """An oval whose walls are 20 mm thick, clockwise."""
    angle = 2.0 * np.pi * a
    return np.stack([(0.5 + 0.02 * zeta) * np.sin(angle), (0.2 + 0.02 * zeta) * np.cos(angle)], -1)


def analyse_walls(mesh, plies):
    table = tabulate_walls(plies, np.array([total_thickness(p) for p in plies]), moments=True)
    density = cell_field(mesh, table.density)
    section = tf.analyse_section(mesh, Laminate.from_table(mesh, table), density)
    return section, SectionPlies(section, plies)


def oval():
    """The section and its plies, in the order of its cells."""
    a, zeta = np.arange(2 * AROUND) / (2 * AROUND), np.array([-0.5, 0.0, 0.5])
    points = loop(*np.meshgrid(a, zeta, indexing="ij"))
    number = np.arange(points[..., 0].size).reshape(-1, 3)
    cells = [[number[(2 * n + i) % (2 * AROUND), k] for i, k in GMSH_ORDER] for n in range(AROUND)]
    flat = np.column_stack([points.reshape(-1, 2), np.zeros(points[..., 0].size)])
    mesh = _compat.mesh_of_arrays(MPI.COMM_SELF, "quadrilateral", 2, flat, np.array(cells))
    order = np.asarray(mesh.topology.original_cell_index)
    section, plies = analyse_walls(mesh, [LAYUPS[c % 2] for c in order])
    return section, plies, order


def test_plies_of_a_prism_are_those_of_the_solid_with_its_displacement():
    section, plies, order = oval()
    loads = np.array([0.0, 0.0, 3e-1, 2e-2, -4e-2, 5e-2])

    def place(s, a, z):
        x, y = np.moveaxis(loop(a, z), -1, 0)
        return np.stack([0.3 * s, x, y], axis=-1)

    loaded, number = load_wall(MPI.COMM_SELF, wall_arrays(place, 2, AROUND, closed=True))
    layups = [LAYUPS[c % AROUND % 2] for c in number]
    table = tabulate_walls(layups, np.array([total_thickness(p) for p in layups]))
    law, density = Laminate.from_table(loaded.mesh, table), cell_field(loaded.mesh, table.density)
    body = tf.FlexibleBody("prism", loaded.mesh, law, density, degree=2)
    system = tf.MultibodySystem(MPI.COMM_SELF, [body])
    state, X = system.initial_state(), system.flexible_models[0].positions
    nodes = section.prism.space.tabulate_dof_coordinates()[:, :2]
    gaps = np.linalg.norm(nodes[None] - X[:, None, 1:], axis=2)
    assert gaps.min(axis=1).max() < 1e-9
    warping = section.warping(loads).x.array.reshape(-1, 3)[gaps.argmin(axis=1)]
    # without forces across, the section's displacement along the prism is that of a rigid one
    derivative = section.unit_loads.derivative @ loads
    gx, gy, e, kx, ky, kz = np.linalg.lstsq(section.prism.modes, derivative, rcond=None)[0]
    z, x, y = X.T
    rigid = [
        gx * z + ky * z**2 / 2.0 - y * kz * z,
        gy * z - kx * z**2 / 2.0 + x * kz * z,
        z * (e + y * kx - x * ky),
    ]
    u = warping + np.column_stack(rigid)
    state.u[0].array[:] = u[:, [2, 0, 1]].ravel()
    solid = PlyStresses(system, body, layups)
    solid.update(state)
    stresses, of_section = solid.stresses(), plies.stresses(loads)
    largest = np.abs(stresses).max()
    for cell in range(len(number)):
        (own,) = np.flatnonzero(order == number[cell] % AROUND)
        found = of_section[plies.table.wall == own]
        for points in (slice(0, 2), slice(2, 4)):
            expected = stresses[solid.table.wall == cell][:, :, points]
            assert np.allclose(found, expected, rtol=0.0, atol=1e-7 * largest)


def test_plies_of_a_thin_tube_are_those_of_lamination_theory():
    R, t, n = 1.0, 0.004, 32
    layup = laminate(*((GLASS, t / 8.0, a) for a in (45, -45, 0, 90, 90, 0, -45, 45)))
    mesh = wall_ring(R - t / 2.0, R + t / 2.0, n)
    _, plies = analyse_walls(mesh, [layup] * n)
    force, moment, torque = 3e4, 5e4, 2e4
    strains = plies.strains([0.0, 0.0, force, moment, 0.0, torque])
    # N11 and N12 of membranes; N22 is zero
    soft = np.linalg.inv(laminate_stiffness(layup)[0])
    x = mesh.geometry.x[_compat.nodes_of_cells(mesh)]
    y = x[:, :, 1].mean(axis=1)[plies.table.wall]
    N11 = force / (2.0 * np.pi * R) + moment * y / (np.pi * R**3)
    N12 = np.full_like(N11, torque / (2.0 * np.pi * R**2))
    wall = np.stack([N11, 0.0 * N11, N12], axis=1) @ soft
    for k, angle in enumerate((45, -45, 0, 90)):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        e1 = wall @ [c * c, s * s, c * s]
        rows = slice(k, None, 8)
        found = strains[rows, ..., 0].mean(axis=(1, 2))
        assert found == pytest.approx(e1[rows], abs=0.02 * np.abs(e1).max())
    index, worst = plies.largest([0.0, 0.0, force, 0.0, 0.0, 0.0], maximum_strain)
    assert index == pytest.approx(0.0) and np.all(worst == 0)  # no strengths are known


def test_walls_that_are_no_walls_are_refused_in_a_sentence():
    section = tf.analyse_section(rectangle(0.2, 0.1, 2, 2, True), tf.StVenantKirchhoff(1.0, 1.0))
    with pytest.raises(tf.ModelError, match="each of its 4 cells, got 3 laminates, 0 of them"):
        SectionPlies(section, [LAYUPS[0]] * 3)
    with pytest.raises(tf.ModelError, match="1 of them without plies"):
        SectionPlies(section, [LAYUPS[0]] * 3 + [()])
    plies = SectionPlies(section, [LAYUPS[0]] * 4)
    with pytest.raises(tf.ModelError, match="loads of a section"):
        plies.strains([1.0, 2.0])
