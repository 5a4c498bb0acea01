"""gmsh reads files where it can do no harm, and its crashes become sentences."""

import signal
from pathlib import Path

import numpy as np
import pytest
from damage import damaged

from turbine_fenicsx.foundation.interrupts import catch_signals
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshError, gmsh_child, gmsh_process, read_msh
from turbine_fenicsx.meshing.quality import examine

ROTOR = Path(__file__).parents[3] / "meshes" / "blade_rotor_2x2x12.msh"
BLADES, ROOTS = ["blade_1", "blade_2", "blade_3"], ["root_1", "root_2", "root_3"]


@pytest.fixture
def child(monkeypatch, shared_tmp_path):
    """Puts another program in the place of that which runs gmsh."""

    def replace(program):
        path = shared_tmp_path / "child.py"
        path.write_text(program)
        monkeypatch.setattr(gmsh_child, "__file__", str(path))

    return replace


@pytest.fixture
def copy(comm, shared_tmp_path):
    """Makes a copy of the mesh with a change of its text, on rank 0."""

    def make(name="own.msh", change=lambda text: text):
        path = shared_tmp_path / name
        if comm.rank == 0:
            path.write_bytes(change(ROTOR.read_bytes()))
        comm.barrier()
        return path

    return make


def read(comm, path):
    return on_rank0(comm, lambda: read_msh(path, BLADES, ROOTS))


def test_no_script_of_gmsh_is_run(comm, copy, shared_tmp_path, monkeypatch):
    """Neither beside the mesh, where gmsh looks for options, nor in the home of the user."""
    path, sign = copy(), shared_tmp_path / "it ran"
    monkeypatch.setenv("HOME", str(shared_tmp_path))
    if comm.rank == 0:
        for name in ("own.msh.opt", ".gmshrc", ".gmsh-options"):
            (shared_tmp_path / name).write_text(f"SystemCall \"touch '{sign}'\";\n")
    comm.barrier()
    assert len(read(comm, path).cells) == 144
    assert not sign.exists()


@pytest.mark.parametrize("before", ["\n", " ", "\ufeff", "// "])
def test_what_gmsh_would_take_for_a_script_is_refused(comm, copy, before):
    path = copy(change=lambda text: before.encode() + text)
    with pytest.raises(MeshError, match=r"is not a mesh in gmsh's \.msh format"):
        read(comm, path)


@pytest.mark.parametrize("name", ["own.geo", "own.msh.opt", "own", "own.MSH", "msh"])
def test_a_mesh_by_another_name_is_refused(comm, copy, name):
    """The ending decides what else gmsh does with a file."""
    path = copy(name)
    with pytest.raises(MeshError, match=r"is not a mesh in gmsh's \.msh format"):
        read(comm, path)


@pytest.mark.parametrize("number", [b"nan", b"inf", b"-inf", b"1e200"])
def test_a_coordinate_that_is_no_number_is_named(comm, copy, number):
    lines = ROTOR.read_bytes().split(b"\n")
    words = lines[600].split(b" ")
    assert len(words) == 3
    lines[600] = b" ".join([words[0], number, words[2]])
    path = copy(change=lambda text: b"\n".join(lines))
    with pytest.raises(MeshError, match=r"1 of its nodes have .* not finite.* node \d+$"):
        read(comm, path)


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e200])
def test_cells_without_finite_size_are_degenerate(number):
    mesh = read_msh(ROTOR, BLADES, ROOTS)
    points = mesh.points.copy()
    points[mesh.cells[7, 3], 1] = number
    report = examine(points, mesh.cells, mesh.reference, mesh.volumes, mesh.cell_groups)
    touched = np.count_nonzero((mesh.cells == mesh.cells[7, 3]).any(axis=1))
    assert report.bad_cells == touched
    assert f"{touched} of 144 cells are inverted or degenerate" in report.mistakes[0]


@pytest.mark.parallel
@pytest.mark.parametrize("name", ["SIGSEGV", "SIGABRT", "SIGKILL"])
def test_a_crash_of_gmsh_is_a_sentence(comm, copy, child, name):
    child(f"import os, signal; os.kill(os.getpid(), signal.{name})")
    path = copy()
    sentence = rf"^mesh file '.*own.msh': gmsh crashes when it reads it \({name}\)"
    with pytest.raises(MeshError, match=sentence):
        read(comm, path)


def test_a_file_that_gmsh_never_finishes_is_a_sentence(comm, copy, child, monkeypatch):
    child("import time; time.sleep(60)")
    monkeypatch.setattr(gmsh_process, "PATIENCE", 0.1)
    monkeypatch.setattr(gmsh_process, "SLOWEST", 1e6)
    path = copy()
    with pytest.raises(MeshError, match="gmsh has not read it within 0 s"):
        read(comm, path)


def test_without_gmsh_it_says_how_to_get_it(comm, copy, child):
    child(f"import sys; print('No module', file=sys.stderr); sys.exit({gmsh_child.NO_GMSH})")
    path = copy()
    with pytest.raises(MeshError, match=r"cannot be loaded \(No module\); install it with 'apt"):
        read(comm, path)


def test_too_little_memory_is_a_sentence(comm, copy, child):
    source = Path(gmsh_child.__file__).read_text()
    assert "    gmsh.merge(path)\n" in source
    child(source.replace("    gmsh.merge(path)\n", "    np.ones(10**15)\n"))
    path = copy()
    with pytest.raises(MeshError, match="does not fit into the memory"):
        read(comm, path)


@pytest.mark.parallel
def test_gmsh_knows_nothing_of_mpi(comm, copy, child, monkeypatch):
    """Or a library that it loads would take itself for this rank."""
    for name in ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_FD"):
        monkeypatch.setenv(name, "0")
    child("import os, sys; sys.exit('variables: ' + ' '.join(os.environ))")
    path = copy()
    with pytest.raises(MeshError, match="variables: ") as caught:
        read(comm, path)
    assert not any(name in str(caught.value) for name in ("OMPI_", "PMIX_", "PMI_"))


@pytest.mark.parallel
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_reading_at_once(comm, copy, child, number):
    """Where it would only be noted otherwise; the process that reads is killed."""
    child(
        "import os, pathlib, signal, time\n"
        f"pathlib.Path({str(copy().parent)!r}, 'pid').write_text(str(os.getpid()))\n"
        f"os.kill(os.getppid(), {int(number)})\n"
        "time.sleep(60)\n"
    )
    path = copy()
    with catch_signals(), pytest.raises(KeyboardInterrupt):
        read(comm, path)
    state = Path("/proc", (path.parent / "pid").read_text(), "stat")
    assert not state.exists() or state.read_text().rpartition(") ")[2][0] == "Z"  # killed


def test_every_damaged_mesh_is_refused_in_a_sentence_or_has_finite_cells(comm, copy):
    if comm.size > 1:
        pytest.skip("reads on one rank")
    for seed in range(12):
        path = copy(change=lambda text, seed=seed: damaged(text, np.random.default_rng(seed)))
        try:
            mesh = read_msh(path, BLADES, ROOTS)
        except MeshError as error:
            assert "\n" not in str(error)
            continue
        report = mesh.examine()
        assert report.mistakes or np.isfinite([*report.volumes.values()]).all()
        assert report.mistakes or np.isfinite(mesh.points).all()
