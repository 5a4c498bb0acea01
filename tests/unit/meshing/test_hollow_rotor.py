"""Rotors of hollow blades: copies, groups, and data of cells on all ranks and in files."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx.mesh import compute_midpoints
from hollow_shapes import webbed_ellipse

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import RotorLayout, load_arrays, load_msh, place_blades, read_msh
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.rotor import write_msh
from turbine_fenicsx.meshing.session import gmsh_session

pytestmark = pytest.mark.parallel

comm = MPI.COMM_WORLD
SHAPE = webbed_ellipse()
LAYOUT = RotorLayout(centre=(0.0, 1.0, -5.0), pitch=0.3)
GROUPS = LAYOUT.volume_groups, LAYOUT.surface_groups


@pytest.fixture(scope="module")
def block():
    return mesh_hollow(SHAPE, 6, 20)


@pytest.fixture(scope="module")
def arrays(block):
    return place_blades(block, LAYOUT)


@pytest.fixture(params=["arrays", "file"])
def loaded(request, arrays, tmp_path):
    if request.param == "arrays":
        return load_arrays(comm, lambda: arrays, "mesh")
    path = comm.bcast(tmp_path) / "hollow.msh"
    on_rank0(comm, lambda: write_msh(arrays, path))
    return load_msh(comm, path, *GROUPS)


def test_copies_have_the_volume_and_the_groups_of_one_blade(block, arrays):
    report = arrays.examine()
    volumes = list(report.volumes.values())
    np.testing.assert_allclose(volumes, volumes[0], rtol=1e-12)
    for k in (1, 2, 3):
        for name, faces in (("root", block.root), ("skin", block.skin)):
            found = arrays.facets[arrays.facet_groups == arrays.surfaces[f"{name}_{k}"]]
            np.testing.assert_array_equal(found, faces + (k - 1) * len(block.points))


def test_skin_is_all_that_the_wind_sees(loaded):
    """Inner faces, webs and the open tip are in no group."""
    for k in (1, 2, 3):
        facets = loaded.facets(f"skin_{k}")
        middle = compute_midpoints(loaded.mesh, 2, facets)
        local = (middle - np.asarray(LAYOUT.centre)) @ LAYOUT.frame(k).T
        s = (local[:, 0] - SHAPE.hub_radius) / SHAPE.length
        c, d = np.cos(SHAPE.twist(s)), np.sin(SHAPE.twist(s))
        x, y = c * local[:, 1] + d * local[:, 2], c * local[:, 2] - d * local[:, 1]
        radius = np.hypot(x, y / SHAPE.ratio) / (SHAPE.chord(s) / 2.0)
        # the ellipse's inner face is at 0.93 and below; midpoints are those of corners
        assert np.all(radius > 0.94)


def test_data_of_cells_come_right_on_every_rank(loaded):
    """Centres of cells lie in the ranges that their data say."""
    data = loaded.cell_data
    owned = loaded.mesh.topology.index_map(3).size_local
    assert {len(values) for values in data.values()} == {owned}
    middle = compute_midpoints(loaded.mesh, 3, np.arange(owned, dtype=np.int32))
    seen = 0
    for k in (1, 2, 3):
        cells = loaded.cells(f"blade_{k}")
        cells = cells[cells < owned]
        local = (middle[cells] - np.asarray(LAYOUT.centre)) @ LAYOUT.frame(k).T
        s = (local[:, 0] - SHAPE.hub_radius) / SHAPE.length
        assert np.all(s > data["span_start"][cells])
        assert np.all(s < data["span_end"][cells])
        web = data["part"][cells] >= len(SHAPE.panels)
        arc = (data["arc_start"] + data["arc_end"])[cells] / 2.0
        contour = SHAPE.surface(s, arc)
        assert np.all(np.linalg.norm(contour - local, axis=1)[~web] < 0.15)
        seen += len(cells)
        assert web.any() or comm.size > 1
    assert comm.allreduce(seen) == comm.allreduce(owned)


def test_a_file_keeps_sixteen_digits(arrays, tmp_path):
    path = comm.bcast(tmp_path) / "hollow.msh"
    on_rank0(comm, lambda: write_msh(arrays, path))
    again = on_rank0(comm, lambda: read_msh(path, *GROUPS))
    assert set(again.cell_data) == {
        "part", "span_start", "span_end", "arc_start", "arc_end", "wanted", "thickness",
    }  # fmt: skip
    for name, values in arrays.cell_data.items():
        np.testing.assert_allclose(again.cell_data[name], values, rtol=1e-15)
    comm.barrier()


@pytest.mark.skipif(comm.size > 1, reason="about reading, which rank 0 does")
def test_data_of_some_cells_and_of_vectors_are_left_aside(arrays, tmp_path):
    path = tmp_path / "hollow.msh"
    write_msh(arrays, path)
    with gmsh_session({"PostProcessing.SaveMesh": 0}) as gmsh:
        gmsh.merge(str(path))
        model = gmsh.model.getCurrent()
        tags, _ = gmsh.model.mesh.getElementsByType(12)
        for name, some, size in (("some", tags[:5], 1), ("vectors", tags, 3)):
            view = gmsh.view.add(name)
            values = np.ones(size * len(some))
            gmsh.view.addHomogeneousModelData(view, 0, model, "ElementData", some, values)
            gmsh.view.write(view, str(path), True)
    again = read_msh(path, *GROUPS)
    assert set(again.cell_data) == set(arrays.cell_data)
