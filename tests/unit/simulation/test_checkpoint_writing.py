"""Claims about when checkpoints are written, and about what happens when they cannot be."""

import gc
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records.checkpoint_file import list_checkpoints
from turbine_fenicsx.simulation.checkpoint import Checkpoints, write_restart_data

pytestmark = pytest.mark.parallel


def test_what_another_program_left_half_written_is_removed(system, example, shared_tmp_path):
    """A program that was killed while it wrote cannot tidy up; a later one can."""
    if system.comm.rank == 0:
        (shared_tmp_path / "checkpoint_00000001.tmp").write_bytes(b"PK")
    system.comm.barrier()
    checkpoints = Checkpoints(system, shared_tmp_path)
    for index in (2, 3):
        checkpoints.write(index, 0.0, 0.0, example)
    system.comm.barrier()
    assert not list(shared_tmp_path.glob("*.tmp"))


def test_a_folder_that_is_deleted_during_the_run_is_not_made_anew(system, example, shared_tmp_path):
    folder = shared_tmp_path / "checkpoints"
    checkpoints = Checkpoints(system, folder)
    checkpoints.write(1, 0.0, 0.0, example)
    system.comm.barrier()
    if system.comm.rank == 0:
        shutil.rmtree(folder)
    system.comm.barrier()
    with pytest.raises(FileError, match=r"cannot write .*checkpoint_00000002.npz: No such"):
        checkpoints.write(2, 0.0, 0.0, example)
    assert not folder.exists()


def test_everything_is_on_the_disk_before_a_file_gets_its_name(
    system, example, shared_tmp_path, monkeypatch
):
    """And the name itself before an older one is removed."""
    checkpoints, calls = Checkpoints(system, shared_tmp_path), []
    for index in (1, 2):
        checkpoints.write(index, 0.0, 0.0, example)

    def spy(name):
        real = getattr(os, name)

        def call(*arguments):
            what = arguments[-1]
            path = Path(os.readlink(f"/proc/self/fd/{what}") if name == "fsync" else what)
            calls.append((name, path.name))
            return real(*arguments)

        monkeypatch.setattr(os, name, call)

    for name in ("fsync", "replace", "unlink"):
        spy(name)
    checkpoints.write(3, 0.0, 0.0, example)
    if system.comm.rank == 0:
        new, old = "checkpoint_00000003.npz", "checkpoint_00000001.npz"
        order = [("fsync", f"{new}.tmp"), ("replace", new), ("fsync", shared_tmp_path.name)]
        assert [call for call in calls if call[0] != "unlink"] == order
        assert calls[-1] == ("unlink", old)


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_a_failed_one_leaves_the_earlier_ones_alone(system, example, shared_tmp_path):
    """The end of the disk is where a limit for files is."""
    resource = pytest.importorskip("resource")
    checkpoints = Checkpoints(system, shared_tmp_path)
    checkpoints.write(1, 0.0, 0.0, example)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(OSError, match=r"cannot write .*checkpoint_00000002.npz: File too"):
            checkpoints.write(2, 0.02, 0.0, example)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    gc.collect()  # and no noise from what was half written
    system.comm.barrier()
    assert [p.name for p in shared_tmp_path.iterdir()] == ["checkpoint_00000001.npz"]
    assert Checkpoints(system, shared_tmp_path).load().numbers["index"] == 7
    checkpoints.write(2, 0.02, 0.0, example)  # there is room again
    assert len(list_checkpoints(shared_tmp_path)) == 2


@pytest.mark.parametrize("what", ["folder", "old"])
def test_what_cannot_be_done_on_rank_0_is_an_error_everywhere(
    system, example, shared_tmp_path, what
):
    """A file is where the folder should be; folders are where old checkpoints should be."""
    folder = shared_tmp_path / "checkpoints"
    if system.comm.rank == 0:
        if what == "folder":
            folder.write_text("mine")
        for index in (1, 2) if what == "old" else ():
            (folder / f"checkpoint_0000000{index}.npz").mkdir(parents=True)
    system.comm.barrier()
    raised = False
    try:
        Checkpoints(system, folder).write(3, 0.0, 0.0, example)
    except OSError:
        raised = True
    assert system.comm.allgather(raised) == [True] * system.comm.size


def test_a_file_is_complete_when_it_gets_its_name(system, example, shared_tmp_path, monkeypatch):
    seen, replace = [], os.replace

    def spy(source, target):
        with np.load(source) as file:  # all of it is there
            seen.append((sorted(file.files), os.path.exists(target)))
        replace(source, target)

    monkeypatch.setattr(os, "replace", spy)
    write_restart_data(shared_tmp_path / "checkpoint_00000001.npz", system, example, {})
    if system.comm.rank == 0:
        ((names, existed),) = seen
        assert not existed
        assert "head" in names and "nodal.state.u.0" in names


@pytest.mark.parametrize(
    ("every", "times", "expected"),
    [
        (0.0, [0.02, 1.0, 50.0], [False, False, False]),
        (0.1, [0.02, 0.08, 0.1, 0.12, 0.18, 0.2], [False, False, True, False, False, True]),
        (0.3, [0.1 + 0.2, 3 * 0.1, 0.6, 0.9], [True, False, True, True]),  # not quite 0.3
        (0.1, [0.1, 0.2, 0.3], [True, True, True]),  # 0.3 / 0.1 is not quite 3
        (0.05, [0.02, 0.04, 0.06, 0.08, 0.1], [False, False, True, False, True]),
    ],
)
def test_checkpoints_are_due_after_simulated_time(system, tmp_path, every, times, expected):
    checkpoints = Checkpoints(system, tmp_path, every=every)
    checkpoints._written = 0  # nothing is to be written here
    found = []
    for time in times:
        found.append(checkpoints.due(time, 1e9))
        if found[-1]:
            checkpoints.write(0, time, 0.0, RestartData())
    assert found == expected


def test_checkpoints_are_due_after_wall_time(system, tmp_path):
    checkpoints = Checkpoints(system, tmp_path, every_wall=10.0)
    checkpoints._written = 0
    assert [checkpoints.due(0.0, t) for t in (0.0, 9.9, 10.1)] == [False, False, True]
    checkpoints.write(0, 0.0, 10.1, RestartData())
    assert [checkpoints.due(0.0, t) for t in (10.2, 20.0, 20.2)] == [False, False, True]
