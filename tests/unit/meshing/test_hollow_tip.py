"""The plate that closes the tip of a hollow blade."""

import numpy as np
import pytest
from hollow_shapes import ZERO, airfoil, linear, webbed_ellipse

from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_ends import TIP
from turbine_fenicsx.meshing.hollow_shape import Web
from turbine_fenicsx.meshing.quality import cell_volumes, scaled_jacobian
from turbine_fenicsx.meshing.topology import count_coincident_nodes, faces_of

SHAPES = {
    "ellipse": webbed_ellipse(closed_tip=True),
    "without webs": webbed_ellipse(closed_tip=True, webs=(), web_places=()),
    "airfoil": airfoil(closed_tip=True),
    "flatback": airfoil(gap=0.06, closed_tip=True, twist=linear(0.3, 0.3)),
}


@pytest.fixture(params=SHAPES, scope="module")
def shape(request):
    return SHAPES[request.param]


@pytest.fixture(params=[(20, 24), (30, 37)], ids=["even", "odd"], scope="module")
def block(shape, request):
    return mesh_hollow(shape, *request.param)


def test_plate_joins_the_inner_faces_of_both_sides(shape, block):
    tip = block.part == block.parts.index(TIP)
    assert np.count_nonzero(tip) >= 5
    faces = faces_of(block.cells, block.reference)
    assert faces.counts.max() == 2
    assert count_coincident_nodes(block.points, 1e-6) == 0
    assert len(np.unique(block.cells)) == len(block.points)
    # suction to pressure side, so that the first and last face of each cell belong to the wall too
    i = block.reference.lattice[:, 0]
    wall = np.unique(block.cells[~tip])
    assert np.all(np.isin(block.cells[tip][:, i != 1], wall))
    assert not np.any(np.isin(block.cells[tip][:, i == 1], wall))


def test_plate_is_as_thick_as_the_wall_and_lies_at_the_end(shape, block):
    tip = block.part == block.parts.index(TIP)
    assert np.all(block.span[tip, 1] == 1.0)
    assert block.wanted[tip] == pytest.approx(0.05, rel=1e-12)
    # the wall is 5 cm everywhere; twist and taper tilt its inner nodes, which the plate shares
    assert block.thickness[tip] == pytest.approx(0.05, rel=5e-3)
    volumes = cell_volumes(block.points, block.cells, block.reference)[tip]
    assert np.all(volumes > 0.0)
    assert scaled_jacobian(block.points, block.cells, block.reference)[tip].min() > 0.2


def test_plate_fills_most_of_the_end(block):
    """What is left open are the corners at leading and trailing edge."""
    tip = block.part == block.parts.index(TIP)
    end = block.points[block.cells[tip]]
    end = end[:, block.reference.lattice[:, 2] == 2][..., 1:].reshape(-1, 2)
    skin = block.points[np.unique(block.skin)]
    skin = skin[skin[:, 0] > skin[:, 0].max() - 1e-9][:, 1:]
    assert np.ptp(end, axis=0).max() > 0.5 * np.ptp(skin, axis=0).max()


def test_no_plate_where_a_web_reaches_the_tip():
    shape = webbed_ellipse(
        closed_tip=True, webs=(Web("only", 0.0, 1.0),), web_places=((0.25, 0.75),), twist=ZERO
    )
    assert TIP not in mesh_hollow(shape, 20, 24).parts


@pytest.mark.parametrize("around", [4, 5])
def test_tip_stays_open_where_no_columns_face_each_other(around):
    shape = webbed_ellipse(closed_tip=True, webs=(), web_places=(), bounds=(0.0, 0.5, 1.0))
    block = mesh_hollow(shape, 6, around)
    assert not np.any(block.part == block.parts.index(TIP))
    assert len(np.unique(block.cells)) == len(block.points)
