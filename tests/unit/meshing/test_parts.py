"""Claims about ranks that get the same part of each of several equal components."""

import numpy as np
import pytest
from rotor_meshes import BLADE, ROTOR

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.meshing import MeshOptions, load_arrays
from turbine_fenicsx.meshing.load import share_equal_components
from turbine_fenicsx.meshing.rotor import mesh_rotor

pytestmark = pytest.mark.parallel

LAYERS = 24


@pytest.fixture(scope="module")
def rotor():
    return mesh_rotor(BLADE, ROTOR, MeshOptions("hexahedron", 1, elements=(2, 2, LAYERS)))


def count_meeting_nodes(cells, owners):
    """Nodes in cells of several ranks, of more than two, shape (2,)."""
    held = [np.unique(cells[owners == rank]) for rank in np.unique(owners)]
    times = np.bincount(np.concatenate(held))
    return [np.count_nonzero(times > 1), np.count_nonzero(times > 2)]


@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_ranks_get_the_same_slab_of_each_blade_and_meet_in_whole_sections(rotor, ranks):
    order = np.random.default_rng(3).permutation(len(rotor.cells))  # in any order
    owners = share_equal_components(rotor.points, rotor.cells[order], ranks)
    blade = rotor.cell_groups[order]
    for k in np.unique(blade):
        assert np.all(np.bincount(owners[blade == k]) == 4 * LAYERS // ranks)
    assert count_meeting_nodes(rotor.cells[order], owners) == [3 * 9 * (ranks - 1), 0]


def test_parts_of_a_rank_are_one_another_turned(rotor):
    owners = share_equal_components(rotor.points, rotor.cells, 3)
    for rank in range(3):
        parts = [(rotor.cell_groups == k) & (owners == rank) for k in (1, 2, 3)]
        X = [np.unique(rotor.points[rotor.cells[part]].reshape(-1, 3), axis=0) for part in parts]
        for k in (1, 2):
            angle = 2 * np.pi * k / 3
            turns = [rotation_about((0, 0, 1), sign * angle) for sign in (1, -1)]
            moved = [ROTOR.centre + (X[0] - ROTOR.centre) @ Q.T for Q in turns]
            apart = [np.linalg.norm(Y[:, None] - X[k], axis=2).min(axis=1).max() for Y in moved]
            assert min(apart) < 1e-9


def test_unequal_parts_are_not_shared(rotor):
    assert share_equal_components(rotor.points, rotor.cells[5:], 2) is None
    assert share_equal_components(rotor.points, rotor.cells[rotor.cell_groups == 1], 2) is None


def prismatic_rotor(phase):
    """Three bars of 2 x 2 x 48 cubes whose ends look alike, their points and cells."""
    i, j, k = (x.ravel() for x in np.mgrid[:3, :3, :49])
    bar = np.stack([i - 1.0, j - 1.0, k + 3.0], axis=1)
    a, b, c = (x.ravel() for x in np.mgrid[:2, :2, :48])
    corners = [(49 * (3 * (a + p) + b + q) + c + r) for p, q, r in np.ndindex(2, 2, 2)]
    turns = [rotation_about((1, 0, 0), phase + n * 2 * np.pi / 3) for n in range(3)]
    cells = np.stack(corners, axis=1)
    return np.vstack([bar @ Q.T for Q in turns]), np.vstack([cells + n * 441 for n in range(3)])


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.7, 2.0])
def test_bars_whose_ends_look_alike_are_cut_from_the_same_end(phase):
    points, cells = prismatic_rotor(phase)
    owners = share_equal_components(points, cells, 2).reshape(3, -1)
    assert np.array_equal(owners[0], owners[1]) and np.array_equal(owners[0], owners[2])


def test_other_meshes_are_left_to_dolfinx(rotor):
    one = rotor.cell_groups == 1
    assert share_equal_components(rotor.points, rotor.cells[one], 2) is None
    assert share_equal_components(rotor.points, rotor.cells[5:], 2) is None  # one is shorter
    assert share_equal_components(rotor.points, rotor.cells, LAYERS) is None  # too thin


def test_the_mesh_hangs_together_where_ranks_meet(comm, rotor):
    """As many nodes and faces on the surface as without ranks, and no cell on two of them."""
    loaded = load_arrays(comm, lambda: rotor, "rotor")
    topology = loaded.mesh.topology
    topology.create_entities(2)
    cells, vertices = topology.index_map(3), topology.index_map(0)
    assert cells.size_global == len(rotor.cells)
    assert vertices.size_global == len(rotor.points)
    if comm.size in (2, 3, 4):
        assert cells.size_local == len(rotor.cells) // comm.size
    surface = comm.allreduce(len(_compat.exterior_facets(loaded.mesh)))
    assert surface == 3 * (2 * 4 + LAYERS * 8)
    assert comm.allreduce(len(loaded.facets("root_2"))) == 4
