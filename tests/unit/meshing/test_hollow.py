"""Structured hexahedra of hollow blades."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hollow_shapes import ZERO, airfoil, ellipse, linear, naca, tube, webbed_ellipse

from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_shape import Web
from turbine_fenicsx.meshing.quality import cell_volumes, scaled_jacobian
from turbine_fenicsx.meshing.topology import (
    count_coincident_nodes,
    faces_of,
    number_connected_parts,
)

SHAPES = {
    "tube": tube(),
    "ellipse without webs": webbed_ellipse(webs=(), web_places=()),
    "ellipse with one web": webbed_ellipse(
        webs=(Web("only", 0.0, 1.0),), web_places=((0.25, 0.75),), twist=ZERO
    ),
    "ellipse with two webs": webbed_ellipse(),
    "sharp airfoil": airfoil(),
    "thin trailing edge": airfoil(gap=0.003),
    "flatback": airfoil(gap=0.06),
}


@pytest.fixture(params=SHAPES, scope="module")
def shape(request):
    return SHAPES[request.param]


@pytest.fixture(params=[(20, 24), (40, 36)], ids=["coarse", "fine"], scope="module")
def block(shape, request):
    return mesh_hollow(shape, *request.param)


def volumes_of(block):
    return cell_volumes(block.points, block.cells, block.reference)


def jacobian_columns(block):
    """Tangents along the axes of the reference cell at the centre of each cell."""
    gradients = block.reference.shape_gradients(np.full((1, 3), 0.5))[0]
    return np.moveaxis(np.einsum("cni,nj->cij", block.points[block.cells], gradients), 2, 0)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def test_cells_are_well_shaped(block):
    # 0.25 at the tip's leading edge, where the wall takes 80 % of the radius; 0.4 elsewhere
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.2


def test_cells_hang_together_by_faces(block):
    faces = faces_of(block.cells, block.reference)
    assert faces.counts.max() == 2
    assert set(number_connected_parts(len(block.cells), faces.neighbours)) == {0}
    assert count_coincident_nodes(block.points, 1e-6) == 0
    assert len(np.unique(block.cells)) == len(block.points)


def test_boundary_is_skin_inner_faces_root_and_tip(shape, block):
    """A web adds the faces of its own ends and sides; no face is open where a web meets a wall."""
    faces = faces_of(block.cells, block.reference)
    on_web = block.part >= len(shape.panels)
    webs = np.count_nonzero(on_web)
    strips = 0
    ends = 0
    for i in range(len(shape.webs)):
        spans = block.span[block.part == len(shape.panels) + i]
        rows = len(np.unique(spans[:, 0]))
        strips += 2 * rows
        ends += 2 * len(spans) // rows
    ring = np.count_nonzero(~on_web)
    around = np.count_nonzero(~on_web & (block.span[:, 0] == 0.0))
    expected = 2 * ring - strips + 2 * around + 2 * webs + ends
    assert np.count_nonzero(faces.counts == 1) == expected


def test_axes_of_cells_follow_span_section_and_wall(shape, block):
    span, around, through = jacobian_columns(block)
    assert np.all(unit(span)[:, 0] > 0.9)
    web = block.part >= len(shape.panels)
    centre = block.points[block.cells].mean(axis=1)
    contour = shape.surface(block.span.mean(axis=1), block.arc.mean(axis=1))
    own_face = block.arc[:, 1] == block.arc[:, 0]  # of a trailing edge: no place on the contour
    wall = ~web & ~own_face
    outwards = np.sum(unit(contour - centre)[wall] * unit(through)[wall], axis=1)
    assert np.all(outwards > 0.7)
    arcs = [shape.surface(block.span.mean(axis=1), block.arc[:, k]) for k in (0, 1)]
    along = unit(arcs[1][wall] - arcs[0][wall])
    assert np.all(np.sum(along * unit(around)[wall], axis=1) > 0.9)
    assert np.all(around[web, 2] < 0.0)  # from suction to pressure side
    assert np.all(through[web, 1] > 0.0)  # towards the leading edge


def test_outer_nodes_lie_on_the_surface():
    shape = tube(twist=linear(0.0, 1.0))
    block = mesh_hollow(shape, 6, 8)
    radius = np.linalg.norm(block.points[block.skin][..., 1:], axis=-1)
    np.testing.assert_allclose(radius, 1.0, rtol=1e-14)


def test_skin_is_the_outer_surface_and_root_all_of_the_hub_face(shape, block):
    outer = np.unique(block.skin)
    ring = block.part < len(shape.panels)
    np.testing.assert_array_equal(outer, np.unique(block.cells[ring][:, block.reference.faces[1]]))
    at_hub = np.flatnonzero(np.abs(block.points[:, 0] - shape.hub_radius) < 1e-12)
    np.testing.assert_array_equal(np.unique(block.root), at_hub)


@pytest.mark.parametrize("twist", [0.0, 0.5])
def test_volume_of_a_tube(twist):
    """Quadratic arcs: the error falls with the fourth power of their length."""
    exact = pi * (1.0 - 0.95**2) * 20.0
    errors = [
        volumes_of(mesh_hollow(tube(twist=linear(0.0, twist)), 10, n)).sum() / exact - 1.0
        for n in (8, 16)
    ]
    assert abs(errors[1]) < 1e-4
    assert abs(errors[1]) < abs(errors[0]) / 12.0


def test_volume_of_a_cone_counts_the_wall_along_its_normal():
    """A cone of 30 degrees: its wall of 5 cm takes more of a section than 5 cm."""
    shape = tube(chord=linear(8.0, 2.0), length=3.0 / np.tan(np.radians(30.0)))
    slant = 3.0 / np.sin(np.radians(30.0))
    # ends are cut along the section, where the ring is t / cos(30 degrees) wide
    width = 0.05 / np.cos(np.radians(30.0))
    exact = pi * shape.length * width * (4.0 + 1.0 - width)
    assert slant * 0.05 == pytest.approx(shape.length * width)
    assert volumes_of(mesh_hollow(shape, 6, 32)).sum() == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("gap", [0.0, 0.003, 0.06])
def test_volume_of_an_airfoil_converges(gap):
    """No volume is lost at trailing edges, which are filled as far as walls of 60 % reach."""
    coarse, fine = (
        volumes_of(mesh_hollow(airfoil(gap=gap), *n)).sum() for n in ((20, 32), (40, 64))
    )
    assert coarse == pytest.approx(fine, rel=4e-3)


def test_thickness_is_that_of_the_wall_or_less(shape, block):
    web = block.part >= len(shape.panels)
    assert np.all(block.thickness <= block.wanted * (1.0 + 1e-2))
    np.testing.assert_allclose(block.wanted[~web], 0.05)
    np.testing.assert_allclose(block.wanted[web], 0.04)
    np.testing.assert_allclose(block.thickness[web], 0.04, rtol=0.12)


def test_cells_of_a_panel_share_its_contour_without_gaps(shape, block):
    first = np.flatnonzero((block.part < len(shape.panels)) & (block.span[:, 0] == 0.0))
    arc = block.arc[first]
    assert (arc[0, 0], arc[-1, 1]) == (0.0, 1.0)
    np.testing.assert_allclose(arc[1:, 0], arc[:-1, 1], atol=1e-14)
    panel = np.searchsorted(shape.bounds, arc.mean(axis=1), side="right") - 1
    inside = arc[:, 1] > arc[:, 0]
    np.testing.assert_array_equal(block.part[first][inside], panel[inside])


def test_webs_begin_and_end_where_they_should():
    shape = webbed_ellipse(breaks=(0.0, 1.0))
    block = mesh_hollow(shape, 9, 24)
    assert block.parts == (*shape.panels, "rear", "front")
    for i, web in enumerate(shape.webs):
        spans = block.span[block.part == len(shape.panels) + i]
        assert (spans.min(), spans.max()) == pytest.approx((web.start, web.end), abs=1e-12)
        heights = block.arc[block.part == len(shape.panels) + i]
        assert (heights.min(), heights.max()) == (0.0, 1.0)


def test_elements_are_shorter_at_the_root():
    spans = np.unique(mesh_hollow(tube(length=60.0), 20, 8).span)
    steps = np.diff(spans)
    assert len(steps) == 20
    # the boundary layer sqrt(R t) is 0.22 m long, the mean element 3 m
    assert 60.0 * steps[0] < 0.75
    assert steps.max() < 2.0 * steps.mean()


def test_breaks_are_lines():
    shape = tube(breaks=(0.0, 0.137, 0.52, 1.0))
    spans = np.unique(mesh_hollow(shape, 12, 8).span)
    assert np.isin([0.137, 0.52], spans).all()


def test_bounds_of_panels_that_meet_are_kept_apart():
    """A panel without width at the root has narrow cells there, and its width at the tip."""

    class Spreading(type(tube())):
        def lines(self, s):
            half = 0.05 * s
            return np.stack([0.0 * s, 0.5 - half, 0.5 + half, 0.0 * s + 1.0], axis=1)

    shape = Spreading(bounds=(0.0, 0.5, 0.5, 1.0))
    block = mesh_hollow(shape, 8, 16)
    middle = (block.part == 1) & (block.span[:, 1] == 1.0)
    assert np.ptp(block.arc[middle]) == pytest.approx(0.1 * block.span[middle].mean(), abs=3e-3)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.5


def test_a_pointed_tip_ends_before_its_point():
    pointed = tube(chord=lambda s: 2.0 * np.sqrt(1.0 - np.asarray(s)))
    block = mesh_hollow(replace(pointed, thickness=lambda s, a: 0.01 + 0.0 * (s + a)), 20, 16)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.1
    assert 0.99 < block.span.max() < 1.0


def test_webs_that_cross_are_refused():
    shape = webbed_ellipse(web_places=((0.18, 0.68), (0.32, 0.82)))
    with pytest.raises(MeshError, match="webs 'rear' and 'front' of the blade cross"):
        mesh_hollow(shape, 10, 24)


def test_too_few_elements_for_the_webs_are_refused():
    with pytest.raises(MeshError, match=r"mesh\.span = 3: webs begin and end at 3 places"):
        mesh_hollow(webbed_ellipse(), 3, 24)
    with pytest.raises(MeshError, match=r"mesh\.around = 8: the webs and corners .* at least 9"):
        mesh_hollow(webbed_ellipse(), 10, 8)


def test_cells_that_are_inverted_are_refused_with_their_place():
    """An outline that runs the wrong way round turns all cells inside out."""
    shape = webbed_ellipse(outline=lambda a, ratio: ellipse(1.0 - a, ratio), webs=(), web_places=())
    sentence = r"mesh\.around = 16: 96 cells .* in the 'panel_\d' between stations .* Jacobian of -"
    with pytest.raises(MeshError, match=sentence):
        mesh_hollow(shape, 6, 16)


def test_lines_that_swing_leave_no_cell_folded():
    """A panel that shrinks from 5 % to nothing within one element, beside a web that ends there."""

    class Shrinking(type(tube())):
        def lines(self, s):
            edge = np.clip(0.35 - 5.0 * (s - 0.9), 0.3, 0.35)
            return np.stack([0.0 * s, 0.0 * s + 0.3, edge, 0.0 * s + 1.0], axis=1)

    shape = Shrinking(bounds=(0.0, 0.3, 0.35, 1.0))
    block = mesh_hollow(shape, 10, 16)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.3


def test_walls_that_jump_leave_no_cell_folded():
    """From 20 cm to 1 cm at one station and at one line."""

    def wall(s, a):
        return np.where((s < 0.5) & (a < 0.45), 0.2, 0.01)

    shape = tube(thickness=wall, bounds=(0.0, 0.45, 1.0), breaks=(0.0, 0.5, 1.0))
    block = mesh_hollow(shape, 10, 16)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.3
    thick = (block.span[:, 1] <= 0.5) & (block.arc[:, 1] <= 0.45)
    np.testing.assert_allclose(block.thickness[thick], 0.2)


@pytest.mark.parametrize("web", [False, True], ids=["alone", "beside a web"])
@pytest.mark.parametrize(("narrow", "wide"), [(0.01, 0.05), (0.05, 0.01)])
def test_narrow_panels_have_their_own_wall_up_to_their_edges(narrow, wide, web):
    """Caps and reinforcements are narrow, and where their material lies matters."""
    webs = {"webs": (Web("web", 0.0, 1.0),), "web_places": ((0.4, 0.9),)} if web else {}

    def wall(s, a):
        return np.where(np.abs(a - 0.3) < 0.05, narrow, wide) + 0.0 * s

    shape = tube(thickness=wall, bounds=(0.0, 0.25, 0.35, 1.0), **webs)
    block = mesh_hollow(shape, 4, 20)
    np.testing.assert_allclose(block.thickness[block.part == 1], narrow)
    far = ((block.arc[:, 0] > 0.45) | (block.arc[:, 1] < 0.15)) & (block.part < 3)
    np.testing.assert_allclose(block.thickness[far], wide)


def test_open_and_closed_outlines_of_one_airfoil_agree():
    """A sharp edge is cut where a thousandth of the chord remains; nearly nothing is lost."""
    sharp, open_ = (
        volumes_of(mesh_hollow(airfoil(outline=naca(gap)), 20, 48)).sum() for gap in (0.0, 1e-3)
    )
    assert sharp == pytest.approx(open_, rel=5e-3)


def test_thick_walls_that_meet_at_a_blunt_corner_do_not_fold():
    """At an edge of 58 degrees inside, not cut, the inner face loses twice the thickness."""
    shape = airfoil(ratio=0.48, thickness=lambda s, a: 0.15 + 0.0 * (s + a), chord=linear(4.0, 2.0))
    block = mesh_hollow(shape, 12, 20)
    assert scaled_jacobian(block.points, block.cells, block.reference).min() > 0.05
