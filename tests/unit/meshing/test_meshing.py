"""Claims about the meshes of rotors: groups, files, DOLFINx; every rank runs every test."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rotor_meshes import BLADE, KINDS, ROTOR, arrays, comm, write

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshError, MeshOptions, build_rotor, load_arrays, load_msh
from turbine_fenicsx.meshing.rotor import mesh_rotor

pytestmark = pytest.mark.parallel

READY_MESH = Path(__file__).parents[3] / "meshes" / "blade_rotor_2x2x12.msh"


@pytest.mark.parametrize(("cell", "degree"), KINDS)
def test_root_lies_on_the_hub_and_closes_the_skin(cell, degree):
    mesh = arrays(cell, degree)
    root = mesh.facets[mesh.facet_groups == mesh.surfaces["root_1"]]
    on_hub = np.abs(mesh.points[:, 1] - BLADE.hub_radius) < 1e-9
    np.testing.assert_array_equal(np.unique(root), np.flatnonzero(on_hub))
    triangles = mesh.facets[:, :3]
    if cell == "hexahedron":
        triangles = np.vstack([triangles, mesh.facets[:, [0, 2, 3]]])
    a, b, c = mesh.points[triangles].transpose(1, 0, 2)
    np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0, atol=1e-10)


@pytest.mark.parametrize(("cell", "degree"), KINDS)
def test_dolfinx_integrates_the_same_volumes_by_name(shared_tmp_path, cell, degree):
    import ufl
    from dolfinx import fem

    file = shared_tmp_path / "rotor.msh"
    report = on_rank0(comm, lambda: build_rotor(BLADE, ROTOR, MeshOptions(cell, degree), file))
    loaded = load_msh(comm, file, ROTOR.volume_groups, ROTOR.surface_groups)
    assert loaded.cell_names == {"blade_1": 1, "blade_2": 2, "blade_3": 3}
    assert set(loaded.facet_names) == set(ROTOR.surface_groups)
    assert loaded.report.nodes == loaded.mesh.geometry.index_map().size_global == report.nodes
    assert loaded.mesh.topology.index_map(3).size_global == report.cells == loaded.report.cells

    # two forms for all integrals, chosen by constants: compiling is what costs time
    exact = {"quadrature_degree": 7}
    dx = ufl.Measure("dx", loaded.mesh, subdomain_data=loaded.cell_tags, metadata=exact)
    ds = ufl.Measure("ds", loaded.mesh, subdomain_data=loaded.facet_tags, metadata=exact)
    x, n = ufl.SpatialCoordinate(loaded.mesh), ufl.FacetNormal(loaded.mesh)
    pick = [fem.Constant(loaded.mesh, 0.0) for _ in range(6)]
    one, flux = fem.Constant(loaded.mesh, 0.0), fem.Constant(loaded.mesh, 0.0)
    a = fem.Constant(loaded.mesh, np.zeros(3))
    inside = fem.form(sum(pick[k] * (one + ufl.dot(a, x)) * dx(k + 1) for k in range(3)))
    outside = fem.form(
        sum(pick[k] * (one + ufl.dot(a, n) + flux * ufl.dot(x, n)) * ds(k + 1) for k in range(6))
    )

    def integral(form, tag, ones=0.0, direction=(0, 0, 0), out=0.0):
        for k, constant in enumerate(pick):
            constant.value = float(k + 1 == tag)
        one.value, a.value[:], flux.value = ones, direction, out
        return comm.allreduce(fem.assemble_scalar(form))

    for k, (name, tag) in enumerate(loaded.cell_names.items()):
        a1 = ROTOR.frame(k + 1)[0]
        volume = integral(inside, tag, 1.0)
        assert volume == pytest.approx(report.volumes[name], rel=1e-12)
        radius = (integral(inside, tag, 0.0, a1) / volume) - ROTOR.centre @ a1
        assert 19 < radius < 25  # this blade, not another one
        root, skin = (loaded.facet_names[f"{part}_{k + 1}"] for part in ("root", "skin"))
        area = integral(outside, root, 1.0)
        assert 2.2 < area < np.pi * 0.9**2
        assert integral(outside, root, 0.0, a1) == pytest.approx(-area, rel=1e-12)  # flat
        # root and skin enclose the volume: the divergence of x is 3
        total = sum(integral(outside, tag, out=1.0) for tag in (root, skin))
        assert total / 3 == pytest.approx(volume, rel=1e-10)


def test_a_mesh_is_distributed_with_or_without_a_file(shared_tmp_path):
    file = shared_tmp_path / "rotor.msh"
    arrays = mesh_rotor(BLADE, ROTOR, MeshOptions(geometry_degree=2))
    write(file, arrays)
    mine, read = load_arrays(comm, lambda: arrays, "mesh"), load_msh(comm, file)
    assert (mine.cell_names, mine.facet_names) == (read.cell_names, read.facet_names)
    # the same mesh, though partitioners may share it out in another way each time
    nodes, cells, facets = (
        [function(loaded) for loaded in (mine, read)]
        for function in (all_nodes, lambda m: owned_by_tag(m, 3), lambda m: owned_by_tag(m, 2))
    )
    np.testing.assert_allclose(nodes[0], nodes[1], atol=1e-8)
    assert cells[0] == cells[1] and facets[0] == facets[1]


def all_nodes(loaded):
    """Positions of the nodes of all ranks, each once, in order."""
    x = np.round(loaded.mesh.geometry.x, 9) + 0.0
    return np.unique(np.concatenate(comm.allgather(x)), axis=0)


def owned_by_tag(loaded, dim):
    """Number of cells or facets of each tag on all ranks."""
    tags = loaded.cell_tags if dim == 3 else loaded.facet_tags
    owned = tags.indices < loaded.mesh.topology.index_map(dim).size_local
    values, counts = np.unique(
        np.concatenate(comm.allgather(tags.values[owned])), return_counts=True
    )
    return dict(zip(values.tolist(), counts.tolist(), strict=True))


def test_every_rank_count_sees_every_tagged_face_once(shared_tmp_path):
    file = shared_tmp_path / "rotor.msh"
    write(file, mesh_rotor(BLADE, ROTOR, MeshOptions()))
    loaded = load_msh(comm, file)
    owned = loaded.facet_tags.indices < loaded.mesh.topology.index_map(2).size_local
    values = loaded.facet_tags.values[owned]
    counts = comm.allreduce(np.array([np.count_nonzero(values == k) for k in range(1, 7)]))
    np.testing.assert_array_equal(counts, [4, 100] * 3)


def test_groups_of_a_loaded_mesh_are_found_by_name():
    from dolfinx.mesh import compute_midpoints

    loaded = load_arrays(comm, lambda: mesh_rotor(BLADE, ROTOR, MeshOptions()), "mesh")
    domain = loaded.mesh
    cells = loaded.cells("blade_2")
    middle = compute_midpoints(domain, 3, cells)
    assert np.all((middle - ROTOR.centre) @ ROTOR.frame(2)[0] > 0.0)
    owned = cells < domain.topology.index_map(3).size_local
    assert comm.allreduce(np.count_nonzero(owned)) == 48
    facets = loaded.facets("root_2")
    heights = (compute_midpoints(domain, 2, facets) - ROTOR.centre) @ ROTOR.frame(2)[0]
    np.testing.assert_allclose(heights, BLADE.hub_radius, atol=1e-12)
    with pytest.raises(MeshError, match=r"no physical surface 'root_4'; it has root_1, skin_1"):
        loaded.facets("root_4")


def test_cells_of_a_loaded_mesh_know_their_row_in_its_arrays():
    from dolfinx.mesh import compute_midpoints

    arrays = mesh_rotor(BLADE, ROTOR, MeshOptions())
    loaded = load_arrays(comm, lambda: arrays, "mesh")
    owned = loaded.mesh.topology.index_map(3).size_local
    rows = loaded.original_cells
    middle = compute_midpoints(loaded.mesh, 3, np.arange(owned, dtype=np.int32))
    expected = arrays.points[arrays.cells[rows]].mean(axis=1)
    np.testing.assert_allclose(middle, expected, atol=1e-12)
    assert sorted(np.concatenate(comm.allgather(rows))) == list(range(len(arrays.cells)))


def test_the_ready_mesh_is_the_default_mesh():
    loaded = load_msh(comm, READY_MESH, ROTOR.volume_groups, ROTOR.surface_groups)
    expected = mesh_rotor(BLADE, ROTOR, MeshOptions()).examine()
    assert (loaded.report.nodes, loaded.report.cells) == (expected.nodes, 144)
    assert loaded.report.worst_quality == pytest.approx(expected.worst_quality)
    assert loaded.report.volumes == pytest.approx(expected.volumes)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_round_off_does_not_choose_among_equally_bad_cells(cell):
    """All blades are congruent, and their cells lie in mirrored pairs."""
    mesh = mesh_rotor(BLADE, ROTOR, MeshOptions(cell, 1, (2, 2, 4)))
    rng = np.random.default_rng(1)
    expected = mesh.examine()
    for _ in range(8):
        points = mesh.points * (1.0 + 1e-15 * rng.standard_normal(mesh.points.shape))
        found = replace(mesh, points=points).examine()
        assert found.worst_group == expected.worst_group == "blade_1"
        assert found.worst_point == pytest.approx(expected.worst_point, abs=1e-9)
