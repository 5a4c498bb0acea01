"""Claims about the description of blades and rotors."""

from dataclasses import replace

import numpy as np
import pytest
from rotor_meshes import BLADE, ROTOR

from turbine_fenicsx.meshing import BladeGeometry, MeshOptions, RotorLayout
from turbine_fenicsx.meshing.rotor import mesh_rotor


def test_default_blades_point_as_in_the_paper():
    spans = np.array([ROTOR.frame(k)[0] for k in (1, 2, 3)])
    half_root3 = np.sqrt(3) / 2
    np.testing.assert_allclose(
        spans, [[half_root3, -0.5, 0], [0, 1, 0], [-half_root3, -0.5, 0]], atol=1e-15
    )
    for k in (1, 2, 3):
        np.testing.assert_allclose(ROTOR.frame(k)[2], [0, 0, 1], atol=1e-15)


def test_blade_frames_are_rotations_for_any_axis_and_pitch():
    layout = RotorLayout(axis=(1, 2, -2), up=(0, 1, 0.3), azimuths=(0.3, 2.0), pitch=0.7)
    for k in (1, 2):
        frame = layout.frame(k)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1)
    flat = replace(layout, pitch=0.0)
    np.testing.assert_allclose(flat.frame(2)[2], np.array([1, 2, -2]) / 3, atol=1e-14)
    turned = layout.frame(2)
    assert turned[1] @ flat.frame(2)[2] == pytest.approx(np.sin(0.7))  # right-handed about a1
    with pytest.raises(ValueError, match="blade 3 does not exist: choose from 1 to 2"):
        layout.frame(3)


def test_a_cone_leans_all_spans_towards_the_axis():
    layout = RotorLayout(axis=(0, 0.6, 0.8), azimuths=(0.3, 2.0, 4.0), cone=0.2)
    flat = replace(layout, cone=0.0)
    for k in (1, 2, 3):
        span, chord, thickness = layout.frame(k)
        assert span @ [0, 0.6, 0.8] == pytest.approx(np.sin(0.2), rel=1e-12)
        assert np.array_equal(chord, flat.frame(k)[1])  # stays in the rotor plane
        assert np.allclose(np.cross(span, chord), thickness, rtol=0, atol=1e-15)
        assert span @ flat.frame(k)[0] == pytest.approx(np.cos(0.2), rel=1e-12)
        out = layout.point_on_span(k, 3.0) - layout.centre
        assert np.allclose(out, 3.0 * span, rtol=0, atol=1e-14)


def test_coned_roots_are_nearer_to_each_other():
    RotorLayout().check_clearance(2.0, 3.3)
    with pytest.raises(ValueError, match="overlap at a hub radius"):
        RotorLayout(cone=-0.4).check_clearance(2.0, 3.3)


def test_blade_volume_is_the_integral_of_its_sections():
    s = np.linspace(0, 1, 100_001)
    areas = np.pi / 4 * BLADE.chord_at(s) * BLADE.thickness_at(s)
    integral = np.sum((areas[1:] + areas[:-1]) / 2) / 100_000 * BLADE.length
    assert BLADE.volume == pytest.approx(integral, rel=1e-8)  # trapezoidal rule of 1e5 steps


def test_volume_of_a_hollow_blade_is_that_of_its_rings():
    blade = BladeGeometry(wall=(0.06, 0.04, 0.01))
    s = (np.arange(4000) + 0.5) / 4000
    angle = np.linspace(0, 2 * np.pi, 2001)
    x = np.outer(blade.chord_at(s) / 2, np.cos(angle))
    y = np.outer(blade.thickness_at(s) / 2, np.sin(angle))
    perimeter = np.hypot(np.diff(x), np.diff(y)).sum(axis=1)
    rings = perimeter * blade.wall_at(s) - np.pi * blade.wall_at(s) ** 2
    assert blade.volume == pytest.approx(rings.mean() * blade.length, rel=1e-6)


def test_positive_twist_turns_the_leading_edge_against_the_thickness_direction():
    """As OpenFAST counts it: upwind, since a3 points downwind."""
    blade = BladeGeometry(twist=(0.3, 0.1, 0.0))
    turned = blade.turn(np.array([[2.25, 0.9, 0.0], [2.25 + 0.1 * 54, 1.0, 0.0]]))
    np.testing.assert_allclose(turned[0], [2.25, 0.9 * np.cos(0.3), -0.9 * np.sin(0.3)])
    np.testing.assert_allclose(turned[1, 1:], [np.cos(0.2), -np.sin(0.2)])


def test_elements_meet_where_twist_or_wall_has_a_kink():
    widths = {"stations": (0, 0.3, 1), "chord": (2, 2, 2), "thickness": (1, 1, 1)}
    assert BladeGeometry(**widths).kinks == (0, 1)
    assert BladeGeometry(**widths, twist=(0.2, 0.1, 0)).kinks == (0, 0.3, 1)
    assert BladeGeometry(**widths, wall=(0.2, 0.1, 0.1)).kinks == (0, 0.3, 1)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_sections_of_a_solid_mesh_are_twisted(cell):
    """Every node of the straight mesh is turned by the twist of its section, volumes stay."""
    options = MeshOptions(cell, geometry_degree=2, elements=(2, 2, 6))
    straight = mesh_rotor(BLADE, ROTOR, options)
    blade = replace(BLADE, twist=(0.2, 0.2, 0.2))
    twisted = mesh_rotor(blade, ROTOR, options)
    frame = ROTOR.frame(2)
    before, after = (
        ((mesh.points - ROTOR.centre) @ frame.T)[np.unique(mesh.cells[mesh.cell_groups == 2])]
        for mesh in (straight, twisted)
    )
    angle = np.arctan2(after[:, 2], after[:, 1]) - np.arctan2(before[:, 2], before[:, 1])
    off_axis = np.hypot(before[:, 1], before[:, 2]) > 1e-3
    turn = np.mod(angle[off_axis] + np.pi, 2 * np.pi) - np.pi
    np.testing.assert_allclose(turn, -0.2, atol=1e-9)
    np.testing.assert_allclose(after[:, 0], before[:, 0], atol=1e-12)


def test_a_blade_with_a_wall_is_meshed_hollow():
    blade = replace(BLADE, wall=(0.06, 0.04, 0.01), twist=(0.3, 0.1, 0.0))
    report = mesh_rotor(blade, ROTOR, MeshOptions(span=20, around=16)).examine()
    # 16 around and 20 along the span, one more at the tip and six of the plate there
    cells = 3 * (16 * 21 + 6)
    assert (report.cell, report.geometry_degree, report.cells) == ("hexahedron", 2, cells)
    # at the tip the wall is thicker than half the radius of the edges and gets thinner there
    for volume in report.volumes.values():
        assert volume == pytest.approx(blade.volume, rel=2e-3)
    assert report.worst_quality > 0.3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BladeGeometry(wall=(0.1, 0.1)), r"blade.wall = \(0.1, 0.1\): .* 3 numbers"),
        (lambda: BladeGeometry(wall=(0.1, 0, 0.1)), r"blade.wall = 0.0: must be greater than 0"),
        (
            lambda: BladeGeometry(wall=(0.1, 0.1, 0.1)),
            r"blade.wall = 0.1: leaves no hollow, expected less than 0.1 m, half of the section",
        ),
        (lambda: BladeGeometry(twist=(0.1,)), r"blade.twist = \(0.1,\): .* 3 numbers"),
        (lambda: MeshOptions(span=0), r"mesh.span = 0: give a whole number from 1"),
        (lambda: MeshOptions(around=2.5), r"mesh.around = 2.5: give a whole number from 3"),
        (lambda: BladeGeometry(length=-54), r"blade.length = -54: must be greater than 0"),
        (lambda: BladeGeometry(hub_radius=float("nan")), r"blade.hub_radius = \[nan\]"),
        (lambda: BladeGeometry(length="long"), r"blade.length = \['long'\]: give finite"),
        (lambda: BladeGeometry(chord=3.0), r"blade.chord = 3.0: give finite numbers"),
        (lambda: BladeGeometry(chord=(1.8, 3.0)), r"blade.chord = \(1.8, 3.0\).* 3 numbers"),
        (lambda: BladeGeometry(thickness=(1.8, 0, 0.2)), r"blade.thickness = 0.0"),
        (lambda: BladeGeometry(stations=(0, 0.2, 0.9)), r"blade.stations .* end with 1"),
        (lambda: BladeGeometry(stations=(0, 0, 1)), r"blade.stations .* increasing"),
        (lambda: RotorLayout(centre=(0, 5)), r"rotor.centre = \(0.0, 5.0\): give three numbers"),
        (lambda: RotorLayout(axis=(0, 0, 0)), r"rotor.axis .* other than zero"),
        (lambda: RotorLayout(up=(0, 0, 2)), r"rotor.up .* not along the axis"),
        (lambda: RotorLayout(azimuths=()), r"rotor.azimuths = \(\)"),
        (lambda: MeshOptions("prism"), r"mesh.cell = 'prism': choose from hexahedron, tetra"),
        (lambda: MeshOptions(geometry_degree=3), r"mesh.geometry_degree = 3: choose 1 or 2"),
        (lambda: MeshOptions(elements=(2, 0, 12)), r"mesh.elements = \(2, 0, 12\)"),
        (lambda: MeshOptions(elements=(2, 2)), r"mesh.elements = \(2, 2\): give three"),
        (lambda: MeshOptions(elements=(2, 2.5, 12)), r"mesh.elements = \(2, 2.5, 12\)"),
        (lambda: MeshOptions(size=0), r"mesh.size = 0: must be a length greater than 0"),
        (
            lambda: mesh_rotor(BLADE, RotorLayout(azimuths=(0, 0.5)), MeshOptions()),
            r"rotor.azimuths .* 28.65 degrees apart overlap",
        ),
    ],
)
def test_bad_parameters_are_refused_by_key_and_value(make, message):
    with pytest.raises(ValueError, match=message):
        make()
