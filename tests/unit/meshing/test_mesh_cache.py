"""Claims about meshes that are kept; every rank runs every test."""

import os
from pathlib import Path

import pytest
from rotor_meshes import BLADE, ROTOR, comm

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import (
    BladeGeometry,
    MeshError,
    MeshOptions,
    RotorLayout,
    build_rotor,
    cache_directory,
    cache_mesh,
    load_msh,
    rotor,
)

pytestmark = pytest.mark.parallel


def test_a_failed_write_leaves_nothing_behind(monkeypatch, shared_tmp_path):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(rotor.os, "replace", full)
    with pytest.raises(MeshError, match=r"rotor.msh': No space left on device$"):
        on_rank0(
            comm, lambda: build_rotor(BLADE, ROTOR, MeshOptions(), shared_tmp_path / "rotor.msh")
        )
    assert list(shared_tmp_path.iterdir()) == []


def test_the_target_is_checked_before_the_work_begins(monkeypatch, shared_tmp_path):
    monkeypatch.setattr(rotor, "mesh_rotor", lambda *_: pytest.fail("meshed in vain"))
    with pytest.raises(MeshError, match=r"cannot write"):
        build_rotor(BLADE, ROTOR, MeshOptions(), shared_tmp_path / "no" / "rotor.msh")


def test_a_mesh_is_built_once_for_the_same_parameters(shared_tmp_path):
    first = cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path)
    stamp = comm.bcast(first.stat().st_mtime_ns)
    comm.barrier()
    assert cache_mesh(comm, BladeGeometry(), RotorLayout(), MeshOptions(), shared_tmp_path) == first
    assert first.stat().st_mtime_ns == stamp
    others = {
        cache_mesh(comm, BladeGeometry(length=53.0), ROTOR, MeshOptions(), shared_tmp_path),
        cache_mesh(comm, BLADE, RotorLayout(pitch=0.1), MeshOptions(), shared_tmp_path),
        cache_mesh(comm, BLADE, ROTOR, MeshOptions(elements=(2, 2, 6)), shared_tmp_path),
    }
    assert len(others | {first}) == 4
    assert sorted(shared_tmp_path.iterdir()) == sorted(others | {first})  # and no temporary files


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "zeros": lambda content: bytes(len(content)),
    "a block of zeros": lambda content: content[:5000] + bytes(512) + content[5512:],
    "no checksum": lambda content: content[: content.index(b"$Comments")],
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_mesh_is_built_anew_and_that_is_said(shared_tmp_path, caplog, damage):
    path = cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path)
    content = path.read_bytes()
    comm.barrier()
    on_rank0(comm, lambda: path.write_bytes(DAMAGES[damage](content)))
    assert cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path) == path
    assert load_msh(comm, path).report.bad_cells == 0
    assert path.read_bytes() == content
    said = [f"the mesh {path} of the cache is damaged; it is built anew"]
    assert caplog.messages == (said if comm.rank == 0 else [])


def test_a_cache_that_others_may_have_written_is_refused(shared_tmp_path):
    on_rank0(comm, lambda: shared_tmp_path.chmod(0o777))
    with pytest.raises(MeshError, match=r"may be written to by everybody \(mode 777; .* your own$"):
        cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path)
    on_rank0(comm, lambda: shared_tmp_path.chmod(0o700))
    path = cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path)
    if os.geteuid() == 0:  # may give files away
        on_rank0(comm, lambda: os.chown(path, 65534, -1))
        with pytest.raises(MeshError, match=r"belongs to the user .*, not to you; or set XDG_"):
            cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path)


def test_the_cache_follows_xdg_cache_home(monkeypatch, shared_tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared_tmp_path))
    assert cache_directory() == shared_tmp_path / "turbine_fenicsx" / "meshes"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_directory() == Path.home() / ".cache" / "turbine_fenicsx" / "meshes"


def test_an_impossible_cache_is_an_error_on_every_rank(shared_tmp_path):
    on_rank0(comm, lambda: (shared_tmp_path / "file").write_text(""))
    with pytest.raises(MeshError, match=r"cannot create the mesh cache"):
        cache_mesh(comm, BLADE, ROTOR, MeshOptions(), shared_tmp_path / "file" / "sub")
    with pytest.raises(ValueError, match=r"overlap"):
        cache_mesh(comm, BLADE, RotorLayout(azimuths=(0, 0.1)), MeshOptions(), shared_tmp_path)
