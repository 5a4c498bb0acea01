"""One run at a time writes to a folder, and a folder that cannot be written to is refused."""

import os
import signal
import subprocess
import sys

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.folder_lock import lock_folder

pytestmark = pytest.mark.parallel

HOLDER = """
import fcntl, os, sys, time
lock = os.open(sys.argv[1], os.O_RDWR)
fcntl.flock(lock, fcntl.LOCK_EX)
print("mine", flush=True)
time.sleep(60)
"""


def test_a_folder_is_made_with_those_above_it(comm, shared_tmp_path):
    with lock_folder(comm, shared_tmp_path / "a" / "b") as folder:
        assert folder == shared_tmp_path / "a" / "b"
        assert folder.is_dir()


def test_what_is_in_a_folder_stays(comm, shared_tmp_path):
    if comm.rank == 0:
        (shared_tmp_path / "history.csv").write_text("mine")
    comm.barrier()
    with lock_folder(comm, shared_tmp_path):
        assert (shared_tmp_path / "history.csv").read_text() == "mine"


def test_a_folder_in_use_is_refused_on_all_ranks_until_it_is_free(comm, shared_tmp_path):
    with lock_folder(comm, shared_tmp_path):
        for _ in range(2):  # a refused run does not free it
            with (
                pytest.raises(InputError, match="in use by another run") as caught,
                lock_folder(comm, shared_tmp_path),
            ):
                pass
            assert repr(str(shared_tmp_path)) in str(caught.value)
        with lock_folder(comm, shared_tmp_path / "below"):  # which is another folder
            pass
    with lock_folder(comm, shared_tmp_path):
        pass


def test_a_run_that_fails_frees_its_folder(comm, shared_tmp_path):
    with pytest.raises(RuntimeError, match="disk full"), lock_folder(comm, shared_tmp_path):
        raise RuntimeError("disk full")
    with lock_folder(comm, shared_tmp_path):
        pass


def test_a_run_that_is_killed_frees_its_folder(comm, shared_tmp_path):
    with lock_folder(comm, shared_tmp_path):
        pass
    holder = None
    if comm.rank == 0:
        command = [sys.executable, "-c", HOLDER, str(shared_tmp_path / ".lock")]
        holder = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert holder.stdout.readline() == "mine\n"
    comm.barrier()
    with pytest.raises(InputError, match="in use"), lock_folder(comm, shared_tmp_path):
        pass
    comm.barrier()
    if holder is not None:
        holder.send_signal(signal.SIGKILL)
        holder.communicate()
    comm.barrier()
    with lock_folder(comm, shared_tmp_path):
        pass


@pytest.mark.parametrize("below", [".", "run", "a/run"])
def test_a_file_in_the_way_is_refused_on_all_ranks(comm, shared_tmp_path, below):
    file = shared_tmp_path / "file"
    if comm.rank == 0:
        file.write_text("mine")
    comm.barrier()
    with (
        pytest.raises(InputError, match="cannot write to") as caught,
        lock_folder(comm, file / below),
    ):
        pass
    assert repr(str(file / below)) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert file.read_text() == "mine"


def test_a_folder_without_permission_is_refused(comm, shared_tmp_path):
    """Root gives up its rights for a while: it may write everywhere."""
    folder, root = shared_tmp_path / "theirs", os.geteuid() == 0
    if comm.rank == 0:
        folder.mkdir(mode=0o555)
        shared_tmp_path.chmod(0o755)
    comm.barrier()
    if root:
        os.seteuid(65534)
    try:
        for path in (folder, folder / "below"):
            with pytest.raises(InputError, match="Permission denied"), lock_folder(comm, path):
                pass
    finally:
        if root:
            os.seteuid(0)
