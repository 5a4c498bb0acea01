"""Lines leave bodies where geometry says so, and sections have their middles."""

import numpy as np
import pytest
from small_body import KINDS, SIZE, small_body

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
from turbine_fenicsx.meshing import TowerGeometry, load_arrays
from turbine_fenicsx.meshing.tower import mesh_tower
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.surface_rays import Skin

pytestmark = pytest.mark.parallel

SECOND = np.pi / 24.0  # angle between the nodes of 24 curved cells around


@pytest.fixture(scope="module")
def cone(comm):
    """A hollow cone below the origin along e2, of radius 2 m at the foot and 1 m at the head."""
    geometry = TowerGeometry(30.0, (0.0, 1.0), (4.0, 2.0), (0.02, 0.02))
    mesh = load_arrays(comm, lambda: mesh_tower(geometry, (24, 1, 6), 2), "mesh").mesh
    return Skin(FlexibleModel(FlexibleBody("cone", mesh, StVenantKirchhoff(1, 1), 1.0, degree=2)))


@pytest.mark.parametrize(("cell", "degree"), KINDS)
def test_lines_leave_a_box_at_its_faces(comm, cell, degree):
    model = small_body(comm, cell, degree, "svk")
    skin, middle = Skin(model), 0.5 * SIZE
    for axis in range(3):
        for sign in (-1.0, 1.0):
            d = sign * np.eye(3)[axis]
            found = skin.leave(middle + np.array([0.01, 0.02, -0.03]), 3.0 * d)
            assert len(found) == 1
            shift = sign * (0.01, 0.02, -0.03)[axis]
            assert found[0].distance == pytest.approx(middle[axis] - shift, rel=1e-12)
            assert found[0].normal == pytest.approx(d, abs=1e-12)
            assert found[0].gradients.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


def test_all_cells_that_meet_at_a_point_are_found(comm):
    skin, middle = Skin(small_body(comm, "hexahedron", 2, "svk")), 0.5 * SIZE
    assert len(skin.leave(middle, (0, 1, 0))) == 2  # the edge between both cells
    corner = skin.leave(middle, SIZE)
    assert sorted(tuple(np.round(c.normal, 12) + 0.0) for c in corner) == [
        (0.0, 0.0, 1.0),
        (0.0, 1.0, 0.0),
        (1.0, 0.0, 0.0),
    ]


def test_a_line_that_misses_leaves_nowhere(comm):
    skin = Skin(small_body(comm, "hexahedron", 1, "svk"))
    assert skin.leave((0.5, 2.0, 0.2), (0, 1, 0)) == []
    assert skin.leave((0.5, 2.0, 0.2), (0, 0, 1)) == []


@pytest.mark.parametrize("azimuth", [0.0, 0.5 * SECOND, SECOND, 1.0, 4.0])
def test_a_line_from_within_a_hollow_cone_leaves_at_its_outer_face(cone, azimuth):
    d = np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
    found = cone.leave((0.0, -12.0, 0.0), d)
    # sections are parabolas through points of the circle, off by angle^4/128 between the nodes
    assert found[0].distance == pytest.approx(1.4, rel=SECOND**4 / 8.0)
    outwards = (d + np.array([0.0, 1.0 / 30.0, 0.0])) / np.hypot(1.0, 1.0 / 30.0)
    normal = np.mean([crossing.normal for crossing in found], axis=0)
    assert normal == pytest.approx(outwards, abs=1e-3)


@pytest.mark.parametrize("height", [3.1, 10.0, 29.0])
def test_middle_of_a_section(cone, height):
    middle = cone.middle((0, -1, 0), height, np.eye(3)[[0, 2]])
    assert middle == pytest.approx([0.0, 0.0], abs=1e-3)
    assert cone.middle((0, -1, 0), 31.0, np.eye(3)[[0, 2]]) is None


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_middle_of_a_leaning_section(comm, cell):
    """A plane across the diagonal of a box; the middle of its extents is on the axis of the box."""
    skin = Skin(small_body(comm, cell, 1, "svk"))
    a = np.sqrt(0.5)
    middle = skin.middle((a, a, 0), a * 0.6, [(a, -a, 0), (0, 0, 1)])
    # it cuts x + y = 0.6 from (0.6, 0) to (0.1, 0.5)
    assert middle == pytest.approx([a * 0.1, 0.2], abs=1e-12)
