"""Blades of windIO files: outer surface, lines between panels, webs."""

import numpy as np
import pytest
from windio_files import IEA_15, IEA_22, at, curve, load_turbine, small_blade

from turbine_fenicsx.windio.airfoils import BODY, FACE

BOTH = pytest.mark.parametrize("name", [IEA_22, IEA_15])
S = np.linspace(0.0, 1.0, 301)
PANELS = (
    *("trailing edge", "trailing-edge reinforcement, suction side"),
    *("rear panel, suction side", "spar cap, suction side", "front panel, suction side"),
    *("leading edge", "leading edge"),
    *("front panel, pressure side", "spar cap, pressure side", "rear panel, pressure side"),
    *("trailing-edge reinforcement, pressure side", "trailing edge"),
)


@pytest.fixture
def blade(name):
    return load_turbine(name).blade


@BOTH
def test_the_root_is_plane_and_round(blade):
    a = np.linspace(0.0, 1.0, 101)
    points = blade.surface(np.zeros(1), a)
    assert np.abs(points[:, 0] - blade.hub_radius).max() < 1e-12
    radii = np.hypot(*(points[:, 1:] - 0.5 * (points[0, 1:] + points[50, 1:])).T)
    assert np.ptp(radii) < 0.005 * radii.mean()  # the files' circles are polygons, IEA-22's is cut


@BOTH
def test_webs_run_in_planes_of_the_blade_as_the_file_says_they_do(blade, name):
    """The anchors' places were computed from offsets of planes, which nothing here has read."""
    offsets = {"web0": 2.0} if name == IEA_22 else {"web0": -0.35, "web1": 0.35}
    for k, web in enumerate(blade.webs):
        if web.name not in offsets:
            continue
        s = np.linspace(web.start + 0.02, web.end - 0.02, 30)
        points = blade.surface(s[:, None], blade.web_arcs(k, s))
        bound = 0.03 if name == IEA_22 else 0.08  # IEA-15's were computed on open trailing edges
        assert np.abs(-points[..., 1] - offsets[web.name]).max() < bound


@BOTH
def test_panels_are_named_after_what_they_are(blade):
    assert blade.panels == PANELS


@BOTH
def test_lines_never_touch_between_the_corners(blade):
    gaps = np.diff(blade.lines(S), axis=1)
    assert gaps.min() >= 0.0
    assert gaps[:, 1:-1].min() > 0.0049  # 9 cm at the root, 1 cm at the tip


@BOTH
def test_lines_are_the_edges_of_caps_where_these_are_thick(blade):
    lines = blade.lines(S)
    for layer in blade.layers:
        if not layer.name.lower().startswith("spar_cap"):
            continue
        first = blade.panels.index(
            f"spar cap, {'suction' if layer.name.lower().endswith('ss') else 'pressure'} side"
        )
        thick = layer.thickness_at(S) > 0.2 * layer.thickness.values.max()
        assert thick.sum() > 150
        for line, edge in ((first, layer.start), (first + 1, layer.end)):
            assert np.abs(lines[thick, line] - edge(S[thick])).max() < 5e-4


@BOTH
def test_lines_bend_gently(blade):
    """By less than a fifth of a circle from element to element, on the blade's own surface."""
    lines = blade.lines(S)
    points = blade.surface(S[:, None], lines)[:, 2:-2]
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=2)[..., None]
    cosines = np.sum(steps[1:] * steps[:-1], axis=2)
    assert np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).max() < 25.0


@BOTH
def test_webs_stay_within_their_panels(blade):
    for k, web in enumerate(blade.webs):
        s = np.linspace(web.start, web.end, 101)
        arcs, lines = blade.web_arcs(k, s), blade.lines(s)
        for side in (0, 1):
            panels = (arcs[:, side, None] > lines).sum(axis=1) - 1
            assert len(set(panels)) == 1
            gaps = np.abs(arcs[:, side, None] - lines)
            assert gaps.min() > 0.0025  # 0.003 at the stations of the lines


@BOTH
def test_the_second_line_and_the_last_but_one_are_the_corners(blade):
    s = np.array([0.12, 0.3, 0.6, 0.95])
    lines = blade.lines(s)
    for k, one in enumerate(s):
        contour, arcs = blade.outer_shape.contour(one)
        for corner, index in ((lines[k, 1], FACE), (lines[k, -2], FACE + BODY)):
            assert corner == arcs[index]
            before, after = contour[index] - contour[index - 1], contour[index + 1] - contour[index]
            cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
            assert np.degrees(np.arccos(cosine)) > 25.0


@BOTH
def test_at_its_thickness_a_section_is_the_airfoil_itself(blade):
    """Points of the airfoil lie on the contour up to what linear pieces of it cut off."""
    sections = blade.outer_shape.sections
    for airfoil in sections.airfoils:
        contour, arcs = sections.contour(airfoil.thickness)
        found = np.column_stack([np.interp(airfoil.arcs, arcs, column) for column in contour.T])
        assert np.abs(found - airfoil.points).max() < 2e-3
        assert np.ptp(contour[:, 0]) == pytest.approx(np.ptp(airfoil.points[:, 0]), abs=5e-4)


def test_breaks_are_where_webs_and_layers_begin_and_end():
    assert load_turbine(IEA_22).blade.breaks == pytest.approx([0.0, 0.05, 0.5, 0.95, 0.98, 1.0])
    assert load_turbine(IEA_15).blade.breaks == pytest.approx([0.0, 0.0918, 0.949, 1.0], abs=1e-4)


def test_sections_stand_at_right_angles_to_the_axis_and_turn_with_the_twist(tmp_path):
    """The file's axis is bent and swept; its twist falls from 10 degrees to -1."""
    blade = small_blade(
        tmp_path,
        lambda b, _: b["reference_axis"].update(y=curve((0.0, 0.0), (0.5, 0.2), (1.0, 1.0))),
    )
    shape = blade.outer_shape
    for s in (0.3, 0.6, 0.9):
        step = shape.reference_points(np.array([s - 1e-4, s + 1e-4]))
        tangent = np.diff(step, axis=0)[0]
        tangent /= np.linalg.norm(tangent)
        points = shape.points(np.array([s]), np.linspace(0.0, 1.0, 50))
        assert np.abs((points - shape.reference_points(np.array([s]))[0]) @ tangent).max() < 1e-6
        untwisted = np.array([tangent[2], 0.0, -tangent[0]]) / np.hypot(tangent[0], tangent[2])
        (chordwise,), (normal,) = shape.frames(np.array([s]))
        twist = np.radians(10.0 - 11.0 * s)  # the trailing edge turns to the suction side
        assert (chordwise @ untwisted, normal @ untwisted) == pytest.approx(
            (np.sin(twist), np.cos(twist)), abs=1e-6
        )


def test_the_frame_is_that_of_the_mesher(tmp_path):
    """a1 along the span from the rotor centre, a2 to the leading edge, a3 to the suction side."""
    blade = small_blade(
        tmp_path, lambda b, _: b["outer_shape"].update(twist=curve((0, 0.0), (1, 0.0)))
    )
    trailing, suction, leading, pressure = blade.surface(
        np.full(4, 0.25), np.array([0.0, 0.25, 0.5, 0.75])
    )
    assert leading[1] > 0.0 > trailing[1]
    assert suction[2] > 0.0 > pressure[2] - 0.02
    tip = blade.surface(np.ones(1), np.linspace(0.0, 1.0, 50)).mean(axis=0)
    assert tip[0] == pytest.approx(1.0 + 20.0, abs=0.02)
    assert tip[2] == pytest.approx(-0.5, abs=0.01)  # prebend


def test_a_web_is_straight_to_its_ends_whatever_the_file_has_there(tmp_path):
    """Its layers grow from nothing between 0.1 and 0.2, where its place on the side jumps."""

    def jump(blade, tables):
        blade["structure"]["anchors"].append(
            {
                "name": "jump",
                "start_nd_arc": curve((0.1, 0.1), (0.2, 0.28), (0.3, 0.29), (0.9, 0.3)),
            }
        )
        blade["structure"]["webs"][0]["start_nd_arc"] = at("jump", "start_nd_arc")

    blade = small_blade(tmp_path, jump)
    assert blade.webs[0].start == 0.15000000000000002
    arcs = blade.web_arcs(0, np.array([0.15, 0.2, 0.3]))[:, 0]
    assert arcs == pytest.approx([0.275, 0.28, 0.29])


def test_sections_are_offset_towards_the_suction_side(tmp_path):
    s, a = np.full(4, 0.5), np.array([0.0, 0.25, 0.5, 0.75])
    before = small_blade(tmp_path).outer_shape
    after = small_blade(
        tmp_path, lambda b, _: b["outer_shape"].update(section_offset_x=curve((0, 0.1), (1, 0.1)))
    ).outer_shape
    (normal,) = before.frames(s[:1])[1]
    assert np.abs(after.points(s, a) - before.points(s, a) - 0.1 * normal).max() < 1e-12


def test_a_sharp_trailing_edge_is_cut_at_a_thousandth_of_the_chord(tmp_path):
    def sharpen(blade, tables):
        for airfoil in tables["airfoils"][1:]:
            x, y = (np.array(airfoil["coordinates"][key]) for key in "xy")
            half = np.where(np.arange(len(x)) <= len(x) // 2, y[0], -y[0])
            airfoil["coordinates"]["y"] = (y - half * x).tolist()

    blade, s = small_blade(tmp_path, sharpen), np.array([0.5, 0.8, 1.0])
    lines = blade.lines(s)
    edges = blade.surface(s[:, None], lines[:, [1, -2]])
    width = np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1)
    assert width == pytest.approx(1e-3 * blade.outer_shape.chord.smooth(s), rel=1e-6)
    assert np.all(lines[:, 1] > 1e-4) and np.all(lines[:, -2] < 1.0 - 1e-4)


def test_a_shell_of_skins_alone_has_two_sides(tmp_path):
    def strip(blade, tables):
        structure = blade["structure"]
        keep = ("coat", "outer", "inner")
        structure["layers"] = [x for x in structure["layers"] if x["name"] in keep]
        structure["webs"] = []

    blade = small_blade(tmp_path, strip)
    assert blade.panels == ("trailing edge", "suction side", "pressure side", "trailing edge")
    assert blade.webs == ()
    assert blade.breaks == (0.0, 1.0)
    assert blade.lines(np.array([0.5])).shape == (1, 5)


def test_walls_change_gradually_across_an_edge(tmp_path):
    """The cap ends at 0.3425 in the middle of the span, its 30 mm beside 4.4 mm of skins."""
    blade = small_blade(tmp_path)
    a = np.array([0.32, 0.3445, 0.345, 0.3455, 0.37])
    walls = blade.wall(np.full(5, 0.5), a)
    assert walls[0] == pytest.approx(walls[-1] + 0.03)
    assert np.all(np.diff(walls) < 0.0)
    assert walls[2] == pytest.approx(0.5 * (walls[0] + walls[-1]), rel=1e-6)
