"""Claims about cross-sections: motions of a rod are found as they are put in."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import FlexibleBody, MultibodySystem, StVenantKirchhoff
from turbine_fenicsx.analysis.cross_sections import CrossSections
from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.foundation.rotations import rotation_about

pytestmark = pytest.mark.parallel

LENGTH, WIDTH, HEIGHT, DENSITY = 10.0, 0.4, 0.8, 2.0
MASS = DENSITY * LENGTH * WIDTH * HEIGHT
R = rotation_about((1.0, -2.0, 0.5), 0.7)
"""Axes x, y, z of the rod as columns: across, across, along."""


@pytest.fixture(scope="module")
def rod():
    """Sections of a rod along the third column of R, and its middle line's coordinate z."""
    comm = MPI.COMM_WORLD
    ends = [(-WIDTH / 2, -HEIGHT / 2, 0.0), (WIDTH / 2, HEIGHT / 2, LENGTH)]
    cells = mesh.create_box(comm, ends, [2, 2, 24], mesh.CellType.hexahedron)
    cells.geometry.x[:] = cells.geometry.x @ R.T
    body = FlexibleBody("rod", cells, StVenantKirchhoff(1.0, 1.0), DENSITY)
    system = MultibodySystem(comm, [body])
    piece = Piece("rod", 0, np.arange(system.flexible_models[0].n_owned))
    return CrossSections(system, system.initial_state(), piece, R.T, R[:, 2])


def in_metres(rod, displacements):
    return rod.motion(displacements) / rod.roots


def test_a_translation_is_the_same_at_every_station_and_carries_all_the_mass(rod):
    shift = np.array([0.3, -0.2, 0.5])
    found = rod.motion(np.tile(R @ shift, (len(rod.positions), 1)))
    assert found.shape == (13, 4)
    assert np.allclose(found[:, :3] / rod.roots[:, :3], shift, rtol=0, atol=1e-13)
    assert np.allclose(found[:, 3], 0.0, rtol=0, atol=1e-13)
    assert (found**2).sum() == pytest.approx(MASS * shift @ shift, rel=1e-12)


def test_a_twist_is_the_rotation_of_each_station(rod):
    z = rod.positions @ R[:, 2]
    middles = in_metres(rod, np.outer(z, R[:, 2]))[:, 2]
    assert np.all(np.diff(middles) > 0.7 * LENGTH / 13)
    found = in_metres(rod, 0.01 * z[:, None] / LENGTH * np.cross(R[:, 2], rod.positions))
    assert np.allclose(found[:, :3], 0.0, rtol=0, atol=1e-13)
    assert found[:, 3] == pytest.approx(0.01 * middles / LENGTH, rel=1e-12)


def test_bending_is_a_displacement_across_and_no_twist(rod):
    z = rod.positions @ R[:, 2]
    middles = in_metres(rod, np.outer(z, R[:, 2]))[:, 2]
    found = in_metres(rod, np.outer((z / LENGTH) ** 2, R[:, 0]))
    # a station takes in nodes on both sides of its middle
    assert found[:, 0] == pytest.approx((middles / LENGTH) ** 2, abs=2e-3)
    assert np.allclose(found[:, 1:], 0.0, rtol=0, atol=1e-13)


def test_moments_of_inertia_are_those_of_the_nodes(rod):
    polar = MASS * (WIDTH**2 + HEIGHT**2) / 12
    # masses of 1/4, 1/2, 1/4 at three nodes across: 1/8 of the square of the width, not 1/12
    assert (rod.roots[:, 3] ** 2).sum() == pytest.approx(1.5 * polar, rel=1e-12)
