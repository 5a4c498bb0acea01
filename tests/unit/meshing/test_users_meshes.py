"""Claims about meshes that users bring; every rank runs every test."""

from dataclasses import replace

import pytest
from rotor_meshes import BLADE, ROTOR, arrays, comm, write

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshError, MeshOptions, build_rotor, load_msh
from turbine_fenicsx.meshing.session import gmsh_session


def gmsh_file(file, make, **options):
    """Let gmsh make and write a mesh, on rank 0."""

    def run():
        with gmsh_session({key.replace("_", "."): value for key, value in options.items()}) as g:
            make(g.model)
            g.write(str(file))

    on_rank0(comm, run)


def box(model, name="blade_1"):
    model.occ.addBox(0, 0, 0, 1, 1, 1)
    model.occ.synchronize()
    model.addPhysicalGroup(3, [1], 7)
    model.setPhysicalName(3, 7, name)
    model.mesh.generate(3)


@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
def test_a_users_mesh_loads_whatever_its_numbering_and_other_groups(shared_tmp_path, version):
    def make(model):
        box(model)
        model.addPhysicalGroup(2, [3], 7)
        model.setPhysicalName(2, 7, "root_1")
        model.addPhysicalGroup(1, [1, 2], 9)
        model.addPhysicalGroup(0, [1], 9)
        if version == 4.1:
            model.mesh.setOrder(2)

    file = shared_tmp_path / "own.msh"
    gmsh_file(file, make, Mesh_MshFileVersion=version, Mesh_FirstNodeTag=1000)
    loaded = load_msh(comm, file, ["blade_1"], ["root_1"])
    assert loaded.cell_names == {"blade_1": 7}
    assert loaded.facet_names == {"root_1": 7}
    assert loaded.report.volumes["blade_1"] == pytest.approx(1)
    assert loaded.report.geometry_degree == (2 if version == 4.1 else 1)


def stray(model):
    model.occ.addRectangle(3, 0, 0, 1, 1, 99)
    model.occ.synchronize()
    model.addPhysicalGroup(2, [99], 1)
    box(model)


def flat(model):
    model.occ.addRectangle(0, 0, 0, 1, 1)
    model.occ.synchronize()
    model.addPhysicalGroup(2, [1], 1)
    model.mesh.generate(2)


def skin(model):
    """A mesh of the surfaces of a body alone."""
    tag = model.occ.addBox(0, 0, 0, 1, 1, 1)
    model.occ.synchronize()
    model.addPhysicalGroup(3, [tag], 1)
    model.addPhysicalGroup(2, [1], 2)
    model.mesh.generate(2)


def overlapping(model):
    box(model)
    model.addPhysicalGroup(3, [1], 8)
    model.setPhysicalName(3, 8, "all")


def cubic(model):
    box(model)
    model.mesh.setOrder(3)


def mixed(model):
    model.occ.addRectangle(3, 0, 0, 1, 1, 99)
    model.occ.extrude([(2, 99)], 0, 0, 1, [2], recombine=True)
    model.occ.synchronize()
    model.addPhysicalGroup(3, [1], 3)
    model.occ.addBox(0, 0, 0, 1, 1, 1)
    model.occ.synchronize()
    model.addPhysicalGroup(3, [2], 4)
    model.mesh.generate(3)


@pytest.mark.parallel
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (box, r"lacks the physical volume 'blade_2' and the physical surfaces 'root_1', 'root_2'; "
              r"it has the volume 'blade_1' and no surface$"),
        (flat, r"holds no volume elements, its highest dimension is 2$"),
        (skin, r"holds no volume elements, its highest dimension is 2$"),
        (overlapping, r"'all', 'blade_1' share \d+ elements; .* one physical volume only$"),
        (cubic, r"'Tetrahedron 20'; all must be of one type"),
        (mixed, r"'Tetrahedron 4', 'Prism 6'; all must be of one type"),
        (stray, r"\d+ elements of its physical surfaces are not faces of any cell$"),
    ],
)  # fmt: skip
def test_a_users_mistake_is_one_sentence_on_every_rank(shared_tmp_path, make, message):
    file = shared_tmp_path / "own.msh"
    gmsh_file(file, make)
    names = (["blade_1", "blade_2"], ["root_1", "root_2"]) if make is box else ([], [])
    with pytest.raises(MeshError, match=message) as caught:
        load_msh(comm, file, *names)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_inverted_cells_of_a_users_mesh_are_counted(shared_tmp_path):
    mesh = arrays("hexahedron", 1)
    cells = mesh.cells.copy()
    cells[[3, 30]] = cells[[3, 30]][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    write(shared_tmp_path / "own.msh", replace(mesh, cells=cells))
    with pytest.raises(MeshError, match=r"2 of 48 cells are inverted .* in 'blade_1' at \("):
        load_msh(comm, shared_tmp_path / "own.msh")


@pytest.mark.parallel
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, r"cannot read the mesh file '.*own.msh': No such file or directory$"),
        ("solid of a stereolithography file", r"own.msh' is not a mesh in gmsh's .msh format$"),
        ("$MeshFormat\n9.9 0 8\n$EndMeshFormat\n", r"gmsh reports: Unknown MSH file version"),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", r"it holds no volume elements$"),
    ],
)
def test_a_file_that_is_no_mesh_is_refused_on_every_rank(shared_tmp_path, content, message):
    file = shared_tmp_path / "own.msh"
    if content is not None:
        on_rank0(comm, lambda: file.write_text(content))
    with pytest.raises(MeshError, match=message):
        load_msh(comm, file)


@pytest.mark.parallel
@pytest.mark.parametrize("name", ["no/such/folder.msh", "mesh.vtk"])
def test_a_mesh_that_cannot_be_written_is_refused(shared_tmp_path, name):
    with pytest.raises(MeshError, match=r"cannot write the mesh to .*(no such dir|end with .msh)"):
        on_rank0(comm, lambda: build_rotor(BLADE, ROTOR, MeshOptions(), shared_tmp_path / name))
    assert list(shared_tmp_path.iterdir()) == []
