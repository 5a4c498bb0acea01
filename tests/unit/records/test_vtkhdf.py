"""What VTK's reader and ours find in VTKHDF files, on any number of ranks."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from xdmf_bricks import (
    VTK_TYPES,
    Bricks,
    assert_equal,
    assert_holds,
    comm,
    gathered,
    needs_pyvista,
    read,
)

from turbine_fenicsx.foundation.errors import FileError, InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records import vtkhdf
from turbine_fenicsx.records.field_files import open_series, read_whole_times
from turbine_fenicsx.records.vtkhdf import KINDS
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile

h5py = pytest.importorskip("h5py")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return comm.bcast(tmp_path) / "fields.vtkhdf"


def write(series, times):
    for t in times:
        series.write(t, *Bricks().fields(t))


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """All that our reader finds, by the names of `xdmf_bricks.read`."""

    def read() -> dict[str, np.ndarray]:
        with VtkHdfFile(path) as file:
            found = {"times": file.times}
            for k in range(len(file.times)):
                step = file.read(k)
                assert step.time == file.times[k]
                found |= {f"{k}/points": step.points, f"{k}/kinds": file.types}
                found[f"{k}/vertices"] = file.connectivity
                found |= {f"{k}/point/{name}": x for name, x in step.point_data.items()}
                found |= {f"{k}/cell/{name}": x for name, x in step.cell_data.items()}
        return found

    return on_rank0(comm, read)


@pytest.mark.parallel
@needs_pyvista
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_every_number_of_a_mixed_moving_grid_comes_back(path, dtype):
    times = [0.0, 0.1, 0.2, 0.30000000000000004]
    write(Bricks().series(path, precision=dtype, information={"parts": "words"}), times)
    assert_holds(path, times, dtype)
    assert_equal(read_arrays(path), times, dtype)
    with VtkHdfFile(path) as file:
        assert file.information == {"parts": "words"}


@needs_pyvista
def test_a_series_is_readable_after_every_write_and_grows(path):
    series = Bricks().series(path, room=2)
    for k in range(6):
        write(series, [float(k)])
        assert_holds(path, [float(i) for i in range(k + 1)])
    series.finish()
    assert_holds(path, [float(i) for i in range(6)])
    with h5py.File(path) as file:
        assert len(file["VTKHDF/Steps/Values"]) == 6
    assert sorted(p.name for p in path.parent.iterdir()) == ["fields.npz", path.name, "read.py"]


def test_cells_are_stored_once(path):
    series = Bricks().series(path, room=50)
    write(series, [0.0])
    size = path.stat().st_size
    write(series, np.arange(1.0, 50.0))
    assert path.stat().st_size == size
    points, *fields = Bricks().fields(0.0)
    moving = 8 * points.size + 4 * sum(x.size for group in fields for x in group.values())
    assert size < 50 * moving + 3e4


@needs_pyvista
@pytest.mark.parametrize("moment", ["add_time", "write_at_all"])
def test_a_program_that_ends_in_a_write_leaves_the_earlier_times(path, moment, monkeypatch):
    def end(*_):
        raise KeyboardInterrupt

    series = Bricks().series(path)
    write(series, [0.0, 1.0])
    with monkeypatch.context() as patch:
        patch.setattr(vtkhdf, moment, end)
        with pytest.raises(KeyboardInterrupt):
            write(series, [2.0])
    assert_holds(path, [0.0, 1.0])
    again = Bricks().series(path, append=2.0)
    assert again.last_kept == 1.0
    write(again, [2.0])
    assert_holds(path, [0.0, 1.0, 2.0])


@pytest.mark.parallel
@needs_pyvista
def test_append_keeps_earlier_times_and_drops_later_ones(path):
    write(Bricks().series(path, room=3), 0.1 * np.arange(6))
    second = Bricks().series(path, append=0.30000000000000004)
    assert second.last_kept == pytest.approx(0.2)
    comm.Barrier()
    assert read_whole_times(path).tolist() == (0.1 * np.arange(3)).tolist()
    comm.Barrier()
    write(second, [0.3])
    assert second.sync() == 4
    second.finish()
    kept = [*(0.1 * np.arange(3)).tolist(), 0.3]
    assert_holds(path, kept)
    assert read_whole_times(path).tolist() == kept


@pytest.mark.parametrize("content", [None, b"", b"no HDF5"])
def test_append_begins_where_there_is_nothing(path, content):
    if content is not None:
        path.write_bytes(content)
    assert not len(read_whole_times(path))
    series = Bricks().series(path, append=1.0)
    assert series.last_kept is None
    write(series, [1.0])
    assert read_whole_times(path).tolist() == [1.0]


def test_a_file_is_written_while_somebody_reads_it(path):
    series = Bricks().series(path)
    write(series, [0.0])
    hold = f"import h5py; f = h5py.File({str(path)!r}, 'r'); print('open', flush=True); input()"
    command = [sys.executable, "-c", hold]  # with a lock, as ParaView
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout.readline() == b"open\n"
        write(series, [1.0])
        child.communicate(b"\n")
    assert child.returncode == 0
    assert read_whole_times(path).tolist() == [0.0, 1.0]


def test_other_fields_are_not_appended(path):
    write(Bricks().series(path), [0.0])
    series = Bricks().series(path, append=1.0)
    points, point_data, _ = Bricks().fields(1.0)
    with pytest.raises(ModelError, match="has not the field 'VTKHDF/PointData/other'"):
        series.write(1.0, points, {"other": point_data["speed"]}, {})


@pytest.mark.parallel
@needs_pyvista
def test_ranks_may_hold_no_points_and_no_cells(path):
    n = 8 if comm.rank == comm.size - 1 else 0
    points = Bricks().points[:n]
    cells = [("hexahedron", np.arange(8).reshape(1, 8))] if n else []
    series = open_series(comm, path, cells=cells, n_points=n)
    series.write(3.5, points, {"displacement": points}, {"stress": np.ones(n // 8)})
    found = read(path)
    assert found["times"].tolist() == [3.5]
    assert np.array_equal(found["0/points"], gathered(points))
    assert found["0/cell/stress"].tolist() == [1.0]


def test_a_file_that_somebody_deletes_is_missed(path):
    series = Bricks().series(path)
    write(series, [0.0])
    path.unlink()
    with pytest.raises(FileError, match=r"cannot write .*fields\.vtkhdf"):
        write(series, [1.0])
    assert not path.exists()


@pytest.mark.parallel
@pytest.mark.parametrize("path", ["/dev/null/f.vtkhdf", "/proc/none/f.vtkhdf"])
def test_an_unwritable_path_is_one_sentence_on_all_ranks(path):
    with pytest.raises(OSError, match=rf"^cannot write {path}: .*"):
        Bricks().series(Path(path))


def test_a_full_disk_is_noticed(path, monkeypatch):
    def refuse(*_):
        raise OSError(28, "No space left on device")

    series = Bricks().series(path)
    write(series, [0.0])
    monkeypatch.setattr(vtkhdf.os, "posix_fallocate", refuse)
    with pytest.raises(FileError, match="No space left on device"):
        write(series, [1.0])
    assert read_whole_times(path).tolist() == [0.0]


def test_without_h5py_it_is_said_how_to_get_it(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match="need h5py: apt install python3-h5py for"):
        Bricks().series(path)


def change(name, values):
    def change(file):
        del file[name]
        file[name] = values

    return change


def set_steps(file):
    file["VTKHDF/Steps"].attrs["NSteps"] = -1


def link_elsewhere(file):
    del file["VTKHDF/Points"]
    file["VTKHDF/Points"] = h5py.ExternalLink("/etc/passwd", "/")


def claim_much(file):
    del file["VTKHDF/Points"]
    file.create_dataset("VTKHDF/Points", (10**12, 3), chunks=(10**6, 3))


@pytest.mark.parametrize(
    "damage",
    [
        change("VTKHDF/Connectivity", np.full(26, 10**6)),
        change("VTKHDF/Offsets", np.zeros(6)),
        change("VTKHDF/Types", np.zeros(2)),
        change("VTKHDF/NumberOfPoints", [10**9]),
        change("VTKHDF/NumberOfCells", [-1]),
        change("VTKHDF/Steps/PointOffsets", np.full(64, 10**6)),
        change("VTKHDF/Steps/Values", [1.0, 0.0]),
        change("VTKHDF/Steps/Values", "words"),
        change("VTKHDF/PointData/speed", np.zeros(1)),
        change("VTKHDF/CellData/part", [b"words"]),
        set_steps,
        link_elsewhere,
        claim_much,
        lambda file: file["VTKHDF"].attrs.__setitem__("Type", "ImageData"),
        lambda file: file.__delitem__("VTKHDF"),
    ],
)
def test_damaged_files_are_refused(path, damage):
    write(Bricks().series(path), [0.0, 1.0])
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(InputError, match="is not the field output of a run, or damaged"):
        VtkHdfFile(path)


def test_cut_and_missing_files_are_refused(path):
    with pytest.raises(InputError, match=r"cannot read .* No such file"):
        VtkHdfFile(path)
    write(Bricks().series(path), [0.0])
    os.truncate(path, path.stat().st_size // 2)
    with pytest.raises(InputError, match="cannot read"):
        VtkHdfFile(path)


def test_every_known_kind_has_the_number_of_vtk():
    assert KINDS == VTK_TYPES
