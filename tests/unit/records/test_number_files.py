"""Claims about files of raw numbers that all ranks write."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.records import number_files
from turbine_fenicsx.records.number_files import NumberFiles, Rows


class FullDisk:
    """A file of MPI one of whose calls fails on the last rank."""

    def __init__(self, comm, call):
        self._comm, self._call = comm, call

    def _fail(self, name):
        if name == self._call and self._comm.rank == self._comm.size - 1:
            raise MPI.Exception(MPI.ERR_NO_SPACE)

    def Open(self, *_):
        self._fail("Open")
        return self

    def Write_at_all(self, *_):
        self._fail("Write_at_all")

    def Close(self):
        self._fail("Close")


@pytest.mark.parallel
@pytest.mark.parametrize("call", ["Open", "Write_at_all", "Close"])
def test_what_mpi_cannot_write_is_an_error_on_all_ranks(comm, shared_tmp_path, monkeypatch, call):
    if comm.size == 1:
        pytest.skip("one rank writes without MPI")
    files = NumberFiles(comm, shared_tmp_path / "fields.xdmf", None)
    monkeypatch.setattr(number_files.MPI, "File", FullDisk(comm, call))
    with pytest.raises(FileError, match=r"cannot write .*fields\.bin"):
        files.append([Rows(np.zeros(3), 3 * comm.rank, 3 * comm.size)])
