"""Claims about the file of a rotor; every rank runs every test."""

import pytest
from rotor_meshes import BLADE, ROTOR, comm

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshError, MeshOptions, build_rotor, rotor

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
