"""Files of others: what would never end is refused by every reader, in one sentence."""

import os
import signal
import socket

import pytest

from turbine_fenicsx.case.files import hash_files
from turbine_fenicsx.forces.time_functions import Table
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.files import open_regular, replace_file
from turbine_fenicsx.foundation.text_files import read_text
from turbine_fenicsx.meshing.read import check_header
from turbine_fenicsx.records.mode_tables import read_table
from turbine_fenicsx.records.output_folder import read_history, read_tables
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.aerodyn_files import read_aerodyn, read_aerodyn_polar
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.mann import read_mann_box
from turbine_fenicsx.wind.turbsim import read_turbsim


def read_box(path):
    return read_mann_box(3 * [path], (2, 2, 2), (1.0, 1.0, 1.0), SteadyWind(10.0, 100.0))


def read_primary(path):
    """A primary file that names a polar."""
    primary = path.parent / "primary.dat"
    primary.write_text(f'1 NumAFfiles\n"{path.name}"\n"blade.dat" ADBlFile(1)\n')
    return read_aerodyn(primary, 1.0)


READERS = {
    "text": lambda path: read_text(path, "case file"),
    "turbulence of TurbSim": read_turbsim,
    "a turbulence box": read_box,
    "a polar": read_aerodyn_polar,
    "a polar of a primary file": read_primary,
    "a mesh": check_header,
    "a table of loads": Table.read,
    "a history": read_history,
    "a summary": read_tables,
    "a table of modes": read_table,
    "a file of a case": lambda path: hash_files({"mesh": {"file": str(path)}}, Tables),
}


@pytest.fixture
def pipe(tmp_path):
    """A pipe without a writer; whoever waits for one is woken by a failure."""

    def wake(*_):
        raise AssertionError("waits for a pipe")

    os.mkfifo(tmp_path / "pipe.msh")
    before = signal.signal(signal.SIGALRM, wake)
    signal.setitimer(signal.ITIMER_REAL, 20.0)
    yield tmp_path / "pipe.msh"
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("reader", READERS)
def test_no_reader_waits_for_a_pipe(reader, pipe):
    with pytest.raises((InputError, OSError), match=r"not a regular file") as caught:
        READERS[reader](pipe)
    assert "pipe.msh" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("reader", sorted(set(READERS) - {"a polar of a primary file"}))
def test_no_reader_stumbles_over_a_null_byte_in_a_name(reader, tmp_path):
    with pytest.raises((InputError, OSError), match=r"its name is not valid") as caught:
        READERS[reader](tmp_path / "a\0b.msh")
    assert str(caught.value).isprintable()


def test_a_polar_whose_name_holds_a_null_byte_is_told(tmp_path):
    primary = tmp_path / "primary.dat"
    primary.write_bytes(b'1 NumAFfiles\n"po\0lar.dat"\n"blade.dat" ADBlFile(1)\n')
    with pytest.raises(OSError, match=r"cannot read .*po\\x00lar\.dat': its name is not valid$"):
        read_aerodyn(primary, 1.0)


def test_devices_sockets_and_folders_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    with socket.socket(socket.AF_UNIX) as here:
        here.bind("socket")
        for path in ("/dev/zero", "socket"):
            with pytest.raises(OSError, match="it is not a regular file"):
                open_regular(path)
    with pytest.raises(IsADirectoryError):
        open_regular(tmp_path)


def test_a_link_to_a_file_is_read(tmp_path):
    (tmp_path / "file").write_text("here")
    (tmp_path / "link").symlink_to("file")
    with open_regular(tmp_path / "link") as file:
        assert file.read() == b"here"


def test_no_pipe_is_replaced_by_a_file(pipe):
    with pytest.raises(FileError, match=r"cannot write .*pipe\.msh: it is not a regular file"):
        replace_file(pipe, b"content")
    assert pipe.is_fifo()
    assert not pipe.with_name("pipe.msh.tmp").exists()
