"""Claims about the checks of a mesh that is to be the blades; every rank does the same."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from turbine_fenicsx.meshing import BladeGeometry, MeshOptions, RotorLayout
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.hexahedra import mesh_blade
from turbine_fenicsx.meshing.rotor import mesh_rotor
from turbine_fenicsx.meshing.topology import (
    count_coincident_nodes,
    count_nodes,
    faces_of,
    number_connected_parts,
)
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades

BLADE = BladeGeometry()
ROTOR = RotorLayout(centre=(0.0, 0.0, -5.0))
HEXAHEDRA = mesh_rotor(BLADE, ROTOR, MeshOptions())
CENTRE = np.array(ROTOR.centre)


def examine(mesh):
    """Mistakes and warnings."""
    found = examine_blades(mesh, ROTOR, BLADE)
    return list(found.mistakes), list(found.warnings)


def moved(motion, blade=2, mesh=HEXAHEDRA):
    """The mesh with the nodes of one blade, given from the rotor centre, moved."""
    points = mesh.points.copy()
    nodes = np.unique(mesh.cells[mesh.cell_groups == blade])
    points[nodes] = CENTRE + motion(points[nodes] - CENTRE)
    return replace(mesh, points=points)


def torn(mesh, cells):
    """The mesh with nodes of their own for some cells."""
    rest = np.delete(mesh.cells, cells, axis=0)
    nodes = np.intersect1d(mesh.cells[cells], rest)
    copies = np.arange(len(mesh.points))
    copies[nodes] = len(mesh.points) + np.arange(len(nodes))
    new = mesh.cells.copy()
    new[cells] = copies[new[cells]]
    return replace(mesh, cells=new, points=np.concatenate([mesh.points, mesh.points[nodes]]))


def without(mesh, cells):
    """The mesh without some cells."""
    keep = np.setdiff1d(np.arange(len(mesh.cells)), cells)
    return replace(mesh, cells=mesh.cells[keep], cell_groups=mesh.cell_groups[keep])


def outer(mesh, radius, blade=2):
    """Cells of the upright blade whose centres are beyond a radius."""
    x = mesh.points[mesh.cells].mean(axis=1)[:, 1]
    return np.flatnonzero((mesh.cell_groups == blade) & (x > radius))


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_built_in_meshes_are_good(cell, degree):
    mesh = mesh_rotor(BLADE, ROTOR, MeshOptions(cell, degree, elements=(2, 1, 8)))
    assert examine(mesh) == ([], [])
    assert mesh.examine().mistakes == mesh.examine().warnings == []


def test_layers_that_were_not_merged_fall_apart():
    cells = outer(HEXAHEDRA, 30.0)
    (mistake,), warnings = examine(torn(HEXAHEDRA, cells))
    a, b = sorted((len(cells), 48 - len(cells)), reverse=True)
    # the section between the two parts has 9 nodes
    assert mistake == (
        f"blade_2 falls into 2 parts without a common face, of {a}, {b} cells; 9 nodes of the mesh "
        "lie on top of others, merge them (in gmsh: Coherence)"
    )
    assert warnings == []


def test_a_gap_in_a_blade_is_seen():
    gap = np.setdiff1d(outer(HEXAHEDRA, 30.0), outer(HEXAHEDRA, 36.0))
    assert len(gap)
    (mistake,), _ = examine(without(HEXAHEDRA, gap))
    assert mistake.startswith("blade_2 falls into 2 parts")
    assert mistake.endswith("cells; expected one")


def test_cells_that_share_an_edge_only_do_not_hang_together():
    # beyond 30 m two of the four columns of cells, then the other two of them
    x = HEXAHEDRA.points[HEXAHEDRA.cells].mean(axis=1)
    far, farther = outer(HEXAHEDRA, 30.0), outer(HEXAHEDRA, 40.0)
    near = np.setdiff1d(far, farther)
    gone = [near[x[near, 0] > 0.0], farther[x[farther, 0] < 0.0]]
    (mistake,), _ = examine(without(HEXAHEDRA, np.concatenate(gone)))
    assert mistake.startswith("blade_2 falls into 2 parts without a common face")


def test_a_double_node_inside_one_part_is_a_warning():
    mesh = HEXAHEDRA
    cell = outer(mesh, 50.0)[0]
    cells = mesh.cells.copy()
    cells[cell, 0] = len(mesh.points)
    points = np.concatenate([mesh.points, mesh.points[mesh.cells[cell, :1]]])
    mistakes, (warning,) = examine(replace(mesh, cells=cells, points=points))
    assert mistakes == []
    assert warning.startswith("1 nodes lie on top of others")


def test_overlapping_cells_are_seen():
    mesh, cell = HEXAHEDRA, outer(HEXAHEDRA, 30.0)[:1]
    double = replace(
        mesh,
        cells=np.concatenate([mesh.cells, mesh.cells[cell]]),
        cell_groups=np.concatenate([mesh.cell_groups, mesh.cell_groups[cell]]),
    )
    mistakes, _ = examine(double)
    # it has two neighbours in the section and two along the span; the outer faces have two cells
    assert "4 faces belong to more than two cells, so that cells overlap" in mistakes


def test_cells_outside_of_the_blades_are_counted():
    groups = HEXAHEDRA.cell_groups.copy()
    groups[outer(HEXAHEDRA, 52.0)] = 9
    mistakes, _ = examine(replace(HEXAHEDRA, cell_groups=groups))
    n = len(outer(HEXAHEDRA, 52.0))
    assert mistakes[0] == f"{n} cells belong to none of the groups blade_1, blade_2, blade_3"


def test_a_part_of_another_group_does_not_hold_a_blade_together():
    groups = HEXAHEDRA.cell_groups.copy()
    groups[np.setdiff1d(outer(HEXAHEDRA, 30.0), outer(HEXAHEDRA, 36.0))] = 1
    mistakes, _ = examine(replace(HEXAHEDRA, cell_groups=groups))
    for k in (1, 2):
        assert sum(m.startswith(f"blade_{k} falls into 2 parts") for m in mistakes) == 1


def test_root_on_another_blade_and_inside_of_one():
    surfaces = HEXAHEDRA.surfaces | {"root_1": 3, "root_2": 1}
    mistakes, _ = examine(replace(HEXAHEDRA, surfaces=surfaces))
    assert mistakes == [f"4 faces of the group root_{k} do not lie on blade_{k}" for k in (1, 2)]

    mesh = HEXAHEDRA
    faces = mesh.cells[mesh.cell_groups == 1][:, mesh.reference.faces].reshape(-1, 4)
    _, counts = faces_of(mesh.cells, mesh.reference).find(faces_keys(faces))
    facets = mesh.facets.copy()
    facets[np.flatnonzero(mesh.facet_groups == 1)[0]] = faces[counts == 2][0]
    mistakes, _ = examine(replace(mesh, facets=facets))
    assert mistakes == ["1 faces of the group root_1 lie inside a body, not on its surface"]


def faces_keys(faces):
    """Keys of faces of hexahedra."""
    from turbine_fenicsx.meshing.block import face_keys

    return face_keys(faces, reference_cell("hexahedron", 1))


@pytest.mark.parametrize(
    ("shift", "gap"), [(1.0, "1 m"), (-1.0, "0.84"), (0.05, "0.05"), (0.01, None)]
)
def test_root_away_from_the_hub_is_told_with_distances(shift, gap):
    # shifted inwards the corner of the root, 0.9 m off the axis, is sqrt(1.25^2 + 0.9^2) = 1.54 m
    # from the centre, but its middle node 1.25 m, which is a gap of 1 m
    mistakes, warnings = examine(moved(lambda X: X + np.array([0.0, shift, 0.0])))
    if gap is None:
        assert (mistakes, warnings) == ([], [])
        return
    (sentence,) = mistakes if abs(shift) == 1.0 else warnings
    away = max(shift, -shift)
    assert sentence.startswith("root_2 does not touch the hub: it is ")
    assert f"up to {away:.3g} m from the hub surface of blade.hub_radius = 2.25 m" in sentence
    assert f"it is {2.25 + shift:.4g} m to " in sentence
    assert "(0, 0, -5) m" in sentence


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "disc"])
def test_a_root_may_follow_the_hub(shape):
    def motion(X):
        flat = np.abs(X[:, 1] - 2.25) < 1e-9
        across = {"sphere": X[:, 0] ** 2 + X[:, 2] ** 2, "cylinder": X[:, 0] ** 2, "disc": 0.0}
        X = X.copy()
        X[flat, 1] = np.sqrt(2.25**2 - across[shape] * np.ones(len(X)))[flat]
        return X

    assert examine(moved(motion)) == ([], [])


def test_a_flat_root_may_lie_beside_the_axis_of_the_span():
    assert examine(moved(lambda X: X + np.array([0.15, 0.0, 0.1]))) == ([], [])


def test_a_mesh_in_millimetres_is_recognised():
    millimetres = HEXAHEDRA
    for k in (1, 2, 3):
        millimetres = moved(lambda X: 1e3 * X, k, millimetres)
    mistakes, _ = examine(millimetres)
    assert len(mistakes) == 3
    assert all(m.endswith("; coordinates must be in metres") for m in mistakes)


def turned(degrees):
    """A rotation about the rotor axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return lambda X: X @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize(("degrees", "errors", "warned"), [(90, 1, 0), (20, 0, 1), (5, 0, 0)])
def test_a_blade_in_another_direction_than_its_fibres_is_seen(degrees, errors, warned):
    mistakes, warnings = examine(moved(turned(degrees)))
    assert (len(mistakes), len(warnings)) == (errors, warned)
    for sentence in mistakes + warnings:
        assert sentence == (
            f"blade_2 points {degrees} degrees away from (0, 1, 0), the direction of its span and "
            "fibres"
        )


def test_a_tip_at_another_radius_is_a_warning():
    mistakes, (warning,) = examine(moved(lambda X: X * [1, 1.02, 1] - [0, 0.02 * 2.25, 0]))
    assert mistakes == []
    assert warning.startswith("blade_2 ends at a radius of 57.33 m, not at ")
    assert "56.25 m" in warning


def test_roots_that_share_nodes_are_refused():
    mesh = HEXAHEDRA
    a, b = (np.unique(mesh.facets[mesh.facet_groups == g])[0] for g in (1, 3))
    cells, facets = (np.where(x == b, a, x) for x in (mesh.cells, mesh.facets))
    mistakes, _ = examine(replace(mesh, cells=cells, facets=facets))
    assert "1 nodes belong to the roots of two blades" in mistakes


def test_poor_and_inverted_cells_are_told_apart():
    mesh = moved(lambda X: X * [1, 1, 1])
    corner = mesh.points[mesh.cells[5, 0]].copy()
    middle = mesh.points[mesh.cells[5, [1, 3, 4]]].mean(axis=0)
    for depth, poor, bad in ((0.0, 0, 0), (0.97, 1, 0), (1.2, 0, 1)):
        mesh.points[mesh.cells[5, 0]] = corner + depth * (middle - corner)
        report = mesh.examine()
        assert (len(report.warnings), len(report.mistakes)) == (poor, bad), report


# --- topology ----------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 10, 300])
def test_connected_parts_are_those_of_a_search(n):
    rng = np.random.default_rng(n)
    for n_pairs in (0, n // 2, n, 2 * n):
        pairs = rng.integers(n, size=(n_pairs, 2))
        label = np.arange(n)
        for _ in range(n):
            for a, b in pairs:
                label[[a, b]] = min(label[a], label[b])
        np.testing.assert_array_equal(number_connected_parts(n, pairs), label)


def test_a_long_chain_is_one_part():
    order = np.random.default_rng(0).permutation(100_000)
    assert not number_connected_parts(len(order), np.stack([order[:-1], order[1:]], axis=1)).any()


def test_nodes_on_top_of_others_are_counted():
    points = np.random.default_rng(0).random((1000, 3))
    assert count_coincident_nodes(points, 1e-6) == 0
    doubled = np.concatenate([points, points[:7] + 1e-9, points[:2]])
    assert count_coincident_nodes(doubled, 1e-6) == 9


@pytest.mark.parametrize("geometry_degree", [1, 2])
@pytest.mark.parametrize("elements", [(1, 1, 1), (2, 3, 5)])
def test_nodes_of_hexahedra_are_counted(elements, geometry_degree):
    block = mesh_blade(BLADE, elements, geometry_degree)
    for p in (1, 2):
        nodes = [p * n + 1 for n in elements]
        assert count_nodes(block.cells, block.reference, 3, p) == np.prod(nodes)
        assert count_nodes(block.root, block.reference, 2, p) == nodes[0] * nodes[1]


@pytest.mark.parametrize("geometry_degree", [1, 2])
def test_nodes_of_tetrahedra_are_counted(geometry_degree):
    mesh = mesh_rotor(BLADE, ROTOR, MeshOptions("tetrahedron", geometry_degree, size=2.0))
    vertices = count_nodes(mesh.cells, mesh.reference, 3, 1)
    nodes = count_nodes(mesh.cells, mesh.reference, 3, 2)
    assert vertices == len(np.unique(mesh.cells[:, :4]))
    edges = {tuple(sorted(e)) for c in mesh.cells for e in combinations(c[:4], 2)}
    assert nodes == vertices + len(edges)
    if geometry_degree == 2:
        assert nodes == len(mesh.points)
        assert count_nodes(mesh.facets, mesh.reference, 2, 2) == len(np.unique(mesh.facets))


@pytest.mark.parametrize("way", [(0.0, 0.0, 5.0), (-3.0, 0.0, 1.0)])
def test_a_rotor_beside_its_hub_is_refused(way):
    mistakes, _ = examine(replace(HEXAHEDRA, points=HEXAHEDRA.points + way))
    found = [sentence for sentence in mistakes if "beside the line of its span" in sentence]
    assert len(found) >= 2
    assert "; the root itself has a radius of 0." in found[0]


def test_a_root_a_little_off_its_span_is_a_warning():
    mistakes, warnings = examine(moved(lambda x: x + 0.7 * np.eye(3)[2]))
    assert mistakes == []
    assert any(w.startswith("root_2 lies 0.7 m beside the line of its span") for w in warnings)
