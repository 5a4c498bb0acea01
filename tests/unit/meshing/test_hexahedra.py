"""Claims about blades of hexahedra."""

import numpy as np
import pytest
from rotor_meshes import BLADE, ROTOR

from turbine_fenicsx.meshing import BladeGeometry, MeshOptions
from turbine_fenicsx.meshing.hexahedra import layer_fractions, mesh_blade, section_grid
from turbine_fenicsx.meshing.quality import cell_volumes, scaled_jacobian
from turbine_fenicsx.meshing.rotor import mesh_rotor


def test_default_rotor_has_144_hexahedra_and_the_fine_one_70713_coordinates():
    coarse = mesh_rotor(BLADE, ROTOR, MeshOptions())
    assert (len(coarse.cells), len(coarse.points)) == (144, 3 * 3 * 3 * 13)
    fine = mesh_rotor(BLADE, ROTOR, MeshOptions(elements=(8, 8, 96)))
    assert 3 * len(fine.points) == 70713
    assert len(np.unique(fine.points.round(9), axis=0)) == len(fine.points)
    quadratic = mesh_blade(BLADE, (2, 2, 12), 2)
    assert quadratic.points.shape == (5 * 5 * 25, 3)


@pytest.mark.parametrize("n_span", [2, 3, 12, 13, 96])
def test_a_layer_of_nodes_lies_where_the_outline_kinks(n_span):
    layers = layer_fractions(BLADE, n_span)
    assert len(layers) == n_span + 1
    assert 0.2 in layers
    steps = np.diff(layers)
    if n_span > 5:
        assert steps.max() < 2 * steps.min()
    assert layer_fractions(BLADE, 1).tolist() == [0, 1]


def test_a_station_without_a_kink_needs_no_layer():
    straight = BladeGeometry(stations=(0, 0.3, 1), chord=(1, 1.3, 2), thickness=(1, 1, 1))
    np.testing.assert_allclose(layer_fractions(straight, 4), [0, 0.25, 0.5, 0.75, 1])


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("n", [(2, 2), (3, 3), (6, 3), (8, 8)])
def test_outline_nodes_lie_on_the_ellipse(n, degree):
    grid = section_grid(*n, degree)
    outline = np.concatenate([grid[0], grid[-1], grid[1:-1, 0], grid[1:-1, -1]])
    off = np.abs(np.linalg.norm(outline, axis=1) - 1) > 1e-14
    assert np.count_nonzero(off) == (0 if degree == 1 else 8)  # the middles next to the corners
    assert np.linalg.norm(outline, axis=1).max() < 1 + 1e-14


def test_a_bent_edge_takes_the_middle_of_its_cell_along():
    grid = section_grid(2, 2, 2)
    corners = grid[0, 0] + grid[2, 0] + grid[0, 2] + grid[2, 2]
    bulges = grid[1, 0] - (grid[0, 0] + grid[2, 0]) / 2 + grid[0, 1] - (grid[0, 0] + grid[0, 2]) / 2
    assert np.linalg.norm(bulges) > 0.05
    np.testing.assert_allclose(grid[1, 1] - corners / 4, bulges / 2, atol=1e-15)


def test_size_sets_the_numbers_of_hexahedra():
    assert MeshOptions(size=1.5).hexahedra(BLADE) == (2, 2, 36)
    assert MeshOptions(size=0.25).hexahedra(BLADE) == (12, 8, 216)
    assert MeshOptions(size=100).hexahedra(BLADE) == (1, 1, 1)


# Measured values less 1 %; equal arcs would give 0.119 for 8 x 8 and arcs at the corners 0 for
# degree 2.
@pytest.mark.parametrize(
    ("elements", "linear", "quadratic"),
    [((2, 2, 12), 0.514, 0.241), ((4, 4, 24), 0.338, 0.164), ((8, 8, 96), 0.198, 0.0979)],
)
def test_worst_quality_of_hexahedra(elements, linear, quadratic):
    for degree, bound in ((1, linear), (2, quadratic)):
        mesh = mesh_blade(BLADE, elements, degree)
        worst = scaled_jacobian(mesh.points, mesh.cells, mesh.reference).min()
        assert 0.99 * bound < worst < 1.01 * bound


def test_no_hexahedron_is_degenerate_for_any_numbers_of_elements():
    for n_chord in (1, 2, 3, 5, 16):
        for n_thickness in (1, 2, 3, 5, 16):
            for degree in (1, 2):
                mesh = mesh_blade(BLADE, (n_chord, n_thickness, 2), degree)
                worst = scaled_jacobian(mesh.points, mesh.cells, mesh.reference).min()
                assert worst > 0.03, (n_chord, n_thickness, degree)


def test_linear_hexahedra_miss_only_the_area_between_ellipse_and_polygon():
    grid = section_grid(6, 4, 1)
    outline = np.concatenate([grid[:-1, 0], grid[-1, :-1], grid[:0:-1, -1], grid[0, :0:-1]])
    x, y = outline.T
    polygon = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2
    mesh = mesh_blade(BLADE, (6, 4, 7), 1)
    volume = cell_volumes(mesh.points, mesh.cells, mesh.reference).sum()
    assert volume == pytest.approx(BLADE.volume * polygon / np.pi, rel=1e-13)


@pytest.mark.parametrize(("degree", "order"), [(1, 1.9), (2, 2.8)])
def test_volume_of_hexahedra_converges(degree, order):
    errors = []
    for n in (32, 64):
        mesh = mesh_blade(BLADE, (n, n, 2), degree)
        errors.append(
            1 - cell_volumes(mesh.points, mesh.cells, mesh.reference).sum() / BLADE.volume
        )
    assert min(errors) > 0
    assert np.log2(errors[0] / errors[1]) > order
    assert errors[1] < (2e-4 if degree == 1 else 2e-5)
