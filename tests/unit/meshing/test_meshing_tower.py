"""Claims about the mesh of the tower: shape, groups, quality, files."""

from math import pi, sin

import numpy as np
import pytest

from turbine_fenicsx.meshing import TowerGeometry, build_tower
from turbine_fenicsx.meshing.block import face_keys
from turbine_fenicsx.meshing.read import read_msh
from turbine_fenicsx.meshing.topology import (
    count_coincident_nodes,
    count_nodes,
    faces_of,
    number_connected_parts,
)
from turbine_fenicsx.meshing.tower import mesh_tower

TOWER = TowerGeometry.cone(height=30.0, bottom_diameter=4.0, top_diameter=2.0, wall=0.25)
COUNTS = [(3, 1, 1), (4, 2, 3), (8, 1, 5)]


@pytest.fixture(params=[1, 2], ids=["flat", "curved"])
def degree(request):
    """Geometry degree."""
    return request.param


@pytest.mark.parametrize("elements", COUNTS, ids=str)
def test_volume_is_that_of_the_cone_with_polygons_for_circles(elements, degree):
    volume = mesh_tower(TOWER, elements, degree).examine().volumes["tower"]
    # frustums of radius R_0 to R_1: pi h/3 (R_0^2 + R_0 R_1 + R_1^2), outer minus inner
    frustum = [pi * 30.0 / 3.0 * (a * a + a * b + b * b) for a, b in ((2.0, 1.0), (1.75, 0.75))]
    assert TOWER.volume == pytest.approx(frustum[0] - frustum[1], rel=1e-14)
    angle = 2.0 * pi / elements[0]
    if degree == 1:
        assert volume == pytest.approx(TOWER.volume * sin(angle) / angle, rel=1e-13)
    else:
        # a parabola through three points of an arc; its section lacks angle^4/480 of the area
        assert volume == pytest.approx(TOWER.volume, rel=angle**4 / 400.0)


@pytest.mark.parametrize("elements", COUNTS, ids=str)
def test_cells_form_one_closed_tube(elements, degree):
    mesh = mesh_tower(TOWER, elements, degree)
    around, through, along = elements
    faces = faces_of(mesh.cells, mesh.reference)
    assert np.max(faces.counts) == 2
    outer = np.count_nonzero(faces.counts == 1)
    assert outer == 2 * around * along + 2 * around * through
    assert not np.any(number_connected_parts(len(mesh.cells), faces.neighbours))
    assert count_coincident_nodes(mesh.points, 1e-9) == 0
    p = degree
    nodes = p * around * (p * through + 1) * (p * along + 1)
    assert len(mesh.points) == nodes == count_nodes(mesh.cells, mesh.reference, 3, p)


def test_cells_are_neither_inverted_nor_poor(degree):
    for elements in COUNTS[1:]:
        report = mesh_tower(TOWER, elements, degree).examine()
        assert report.bad_cells == 0
        assert report.worst_quality > 0.7  # a square's corner is 90 degrees, an octagon's 67.5


def test_ends_are_grouped_and_the_top_is_at_the_origin(degree):
    mesh = mesh_tower(TOWER, (6, 2, 3), degree)
    assert mesh.volumes == {"tower": 1}
    boundary = faces_of(mesh.cells, mesh.reference)
    for name, height, radius in (("tower_bottom", -30.0, 2.0), ("tower_top", 0.0, 1.0)):
        facets = mesh.facets[mesh.facet_groups == mesh.surfaces[name]]
        assert len(facets) == 6 * 2
        assert np.all(boundary.find(face_keys(facets, mesh.reference))[1] == 1)
        x = mesh.points[np.unique(facets)]
        assert np.all(x[:, 1] == height)
        r = np.hypot(x[:, 0], x[:, 2])
        assert r.max() == pytest.approx(radius, rel=1e-14)
        assert r.min() == pytest.approx(radius - 0.25, rel=1e-14)


@pytest.mark.parametrize("name", ["height", "bottom_diameter", "top_diameter", "wall"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_sizes_must_be_positive(name, value):
    with pytest.raises(
        ValueError, match=f"^tower.{name.split('_')[-1]} = .*: must be greater than 0"
    ):
        TowerGeometry.cone(**{name: value})


def test_a_wall_without_a_hollow_is_refused():
    with pytest.raises(ValueError, match=r"tower.wall = 1: leaves no hollow, expected less than 1"):
        TowerGeometry.cone(top_diameter=2.0, wall=1.0)


STATIONS = TowerGeometry(
    120.0, (0.0, 0.1, 0.55, 0.8, 1.0), (9.0, 9.0, 7.0, 6.5, 5.0), (0.06, 0.05, 0.04, 0.05, 0.03)
)


def test_volume_between_stations_is_the_integral():
    s = (np.arange(400_000) + 0.5) / 400_000
    d, t = (np.interp(s, STATIONS.stations, v) for v in (STATIONS.diameters, STATIONS.walls))
    assert STATIONS.volume == pytest.approx(120.0 * np.mean(np.pi * t * (d - t)), rel=1e-9)


def test_the_mesh_follows_the_stations():
    mesh = mesh_tower(STATIONS, (8, 1, 20), 2)
    for s, diameter, wall in zip(
        STATIONS.stations, STATIONS.diameters, STATIONS.walls, strict=True
    ):
        x = mesh.points[np.abs(mesh.points[:, 1] - 120.0 * (s - 1.0)) < 1e-9]
        r = np.hypot(x[:, 0], x[:, 2])
        assert r.max() == pytest.approx(0.5 * diameter, rel=1e-12)
        assert r.min() == pytest.approx(0.5 * diameter - wall, rel=1e-12)
    volume = mesh.examine().volumes["tower"]
    assert volume == pytest.approx(STATIONS.volume, rel=1e-3)


@pytest.mark.parametrize(
    ("stations", "diameters", "walls", "sentence"),
    [
        ((0.0, 0.5), (1.0, 1.0), (0.1, 0.1), "must rise from 0 to 1"),
        ((0.0, 0.5, 0.5, 1.0), (1.0,) * 4, (0.1,) * 4, "must rise from 0 to 1"),
        ((0.0, 1.0), (1.0,) * 3, (0.1, 0.1), "needs as many diameters and walls, got 3 and 2"),
        ((0.0, 1.0), (1.0, 1.0), (0.1, 0.5), "tower.wall = 0.5: leaves no hollow"),
    ],
)
def test_stations_that_do_not_fit_are_refused(stations, diameters, walls, sentence):
    with pytest.raises(ValueError, match=sentence):
        TowerGeometry(10.0, stations, diameters, walls)


def test_file_holds_the_same_mesh(degree, tmp_path):
    path = tmp_path / "tower.msh"
    report = build_tower(TOWER, (4, 1, 2), degree, path)
    mesh = read_msh(path, ["tower"], ["tower_bottom", "tower_top"])
    found = mesh.examine()
    assert (found.nodes, found.cells) == (report.nodes, report.cells)
    assert found.volumes["tower"] == pytest.approx(report.volumes["tower"], rel=1e-13)
    assert len(mesh.facets) == 8
