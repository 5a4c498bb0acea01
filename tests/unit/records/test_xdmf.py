"""What PyVista and ParaView find in the files of `XdmfSeries`, on any number of ranks.

The readers run in a child process of rank 0, so that VTK and MPI never meet in one process.
"""

import os
import resource
import shutil
from pathlib import Path

import numpy as np
import pytest
from xdmf_bricks import (
    PARAVIEW_READER,
    VTK_TYPES,
    Bricks,
    assert_equal,
    assert_holds,
    comm,
    gathered,
    needs_pyvista,
    read,
)

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.records.grid_series import VERTICES
from turbine_fenicsx.records.stored_grids import read_grids
from turbine_fenicsx.records.xdmf import KINDS, XdmfSeries


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return comm.bcast(tmp_path)


@pytest.mark.parallel
@needs_pyvista
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_every_number_of_a_mixed_moving_grid_comes_back(folder, dtype):
    series = Bricks().series(folder / "new" / "fields.xdmf", precision=dtype)
    times = [0.0, 0.1, 0.2, 0.30000000000000004]
    for t in times:
        series.write(t, *Bricks().fields(t))
    assert_holds(folder / "new" / "fields.xdmf", times, dtype)


@pytest.mark.skipif(shutil.which("pvpython") is None, reason="ParaView is not installed")
def test_every_reader_of_paraview_finds_the_same(folder):
    series = Bricks().series(folder / "my fields.xdmf")
    times = [0.0, 0.5, 1.0]
    for t in times:
        series.write(t, *Bricks().fields(t))
    found = read(folder / "my fields.xdmf", PARAVIEW_READER, "pvpython")
    for key in ("XDMFReader", "Xdmf3ReaderS", "Xdmf3ReaderT", "automatic"):
        mine = {n.split("/", 1)[1]: v for n, v in found.items() if n.startswith(f"{key}/")}
        assert_equal(mine, times, "float32")


@needs_pyvista
def test_series_is_readable_after_every_write_and_needs_no_close(folder):
    series = Bricks().series(folder / "fields.xdmf")
    for step in range(3):
        series.write(float(step), *Bricks().fields(float(step)))
        assert_holds(folder / "fields.xdmf", [float(i) for i in range(step + 1)])
    found = {name.name for name in folder.iterdir()}
    assert found == {"fields.xdmf", "fields.bin", "fields.npz", "read.py"}


@needs_pyvista
def test_crash_between_numbers_and_xml_leaves_earlier_times(folder, monkeypatch):
    def crash(self, grid):
        raise KeyboardInterrupt

    series = Bricks().series(folder / "fields.xdmf")
    series.write(0.0, *Bricks().fields(0.0))
    series.write(1.0, *Bricks().fields(1.0))
    monkeypatch.setattr(XdmfSeries, "_extend_xml", crash)
    with pytest.raises(KeyboardInterrupt):
        series.write(2.0, *Bricks().fields(2.0))
    assert_holds(folder / "fields.xdmf", [0.0, 1.0])


@needs_pyvista
def test_xml_that_does_not_fit_on_the_disk_leaves_earlier_times(folder):
    bricks = Bricks()
    series = bricks.series(folder / "fields.xdmf")
    for step in range(3):
        series.write(float(step), *bricks.fields(float(step)))
    comm.Barrier()
    heavy, xml = (os.path.getsize(folder / name) for name in ("fields.bin", "fields.xdmf"))
    grid = "<Grid/>" + 4096 * " " + "\n"
    if comm.rank == 0:
        before = (folder / "fields.xdmf").read_bytes()
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (max(xml, heavy) + 1, limits[1]))
        try:
            with pytest.raises(OSError):
                for _ in range(1 + heavy // 4096):
                    series._extend_xml(grid)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        after = (folder / "fields.xdmf").read_bytes()
        assert after.replace(grid.encode(), b"") == before
    series = bricks.series(folder / "fields.xdmf", append=10.0)
    assert_holds(folder / "fields.xdmf", [0.0, 1.0, 2.0])


@pytest.mark.parallel
@needs_pyvista
def test_append_keeps_earlier_times_and_drops_later_ones(folder):
    path = folder / "fields.xdmf"
    first = Bricks().series(path)
    for step in range(6):
        first.write(0.1 * step, *Bricks().fields(0.1 * step))
    size = path.with_suffix(".bin").stat().st_size
    second = Bricks().series(path, append=0.30000000000000004)
    assert_holds(path, [0.0, 0.1, 0.2])
    for t in (0.3, 0.4):
        second.write(t, *Bricks().fields(t))
    assert_holds(path, [0.0, 0.1, 0.2, 0.3, 0.4])
    assert path.with_suffix(".bin").stat().st_size == size


@needs_pyvista
def test_append_repairs_an_xml_that_was_cut_off(folder):
    path = folder / "fields.xdmf"
    first = Bricks().series(path)
    for t in (0.0, 1.0, 2.0):
        first.write(t, *Bricks().fields(t))
    if comm.rank == 0:
        os.truncate(path, path.stat().st_size - 300)
    comm.Barrier()
    second = Bricks().series(path, append=2.0)
    second.write(2.0, *Bricks().fields(2.0))
    assert_holds(path, [0.0, 1.0, 2.0])


@needs_pyvista
def test_append_without_a_file_begins_a_series(folder):
    series = Bricks().series(folder / "fields.xdmf", append=0.5)
    series.write(0.5, *Bricks().fields(0.5))
    assert_holds(folder / "fields.xdmf", [0.5])


@needs_pyvista
@pytest.mark.parametrize("left", ["nothing", "one byte less than two times", "two times"])
def test_append_keeps_the_times_whose_numbers_are_there(folder, left):
    """As after a power cut, where the XML reached the disk and its numbers did not."""
    path, heavy = folder / "fields.xdmf", folder / "fields.bin"
    series = Bricks().series(path)
    sizes = []
    for t in (0.0, 1.0, 2.0):
        series.write(t, *Bricks().fields(t))
        comm.Barrier()
        sizes.append(heavy.stat().st_size)
        comm.Barrier()
    if comm.rank == 0:
        if left == "nothing":
            heavy.unlink()
        else:
            os.truncate(heavy, sizes[1] - (left != "two times"))
    comm.Barrier()
    kept = {"nothing": [], "two times": [0.0, 1.0]}.get(left, [0.0])
    assert [grid.time for grid in read_grids(path)] == kept
    comm.Barrier()
    series = Bricks().series(path, append=5.0)
    assert series.last_kept == (kept[-1] if kept else None)
    series.write(5.0, *Bricks().fields(5.0))
    assert series.sync() == len(kept) + 1
    assert_holds(path, [*kept, 5.0])


@needs_pyvista
@pytest.mark.parametrize("text", ['<Grid Name="mesh"><Time/></Grid>\n', "\udcff<Grid", ""])
def test_append_begins_anew_where_it_finds_nothing_of_its_own(folder, text):
    path = folder / "fields.xdmf"
    if comm.rank == 0:
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
    comm.Barrier()
    series = Bricks().series(path, append=1.0)
    series.write(1.0, *Bricks().fields(1.0))
    assert_holds(path, [1.0])


def test_numbers_that_somebody_deletes_are_missed_at_once(folder):
    """And not made anew, which would leave zeros in the place of the earlier times."""
    series = Bricks().series(folder / "fields.xdmf")
    series.write(0.0, *Bricks().fields(0.0))
    comm.Barrier()
    if comm.rank == 0:
        (folder / "fields.bin").unlink()
    comm.Barrier()
    with pytest.raises(FileError, match=r"cannot write .*fields\.bin"):
        series.write(1.0, *Bricks().fields(1.0))
    with pytest.raises(FileError, match=r"cannot write .*fields\.bin"):
        series.sync()
    assert not (folder / "fields.bin").exists()


def test_new_series_removes_the_old_xml_at_once(folder):
    series = Bricks().series(folder / "fields.xdmf")
    series.write(0.0, *Bricks().fields(0.0))
    Bricks().series(folder / "fields.xdmf")
    assert not (folder / "fields.xdmf").exists()


@pytest.mark.parallel
@needs_pyvista
def test_numbers_beyond_two_gibibytes_go_to_a_further_file(folder):
    series = Bricks().series(folder / "fields.xdmf")
    series._numbers._size = 2**31 - 100
    for t in (0.0, 1.0):
        series.write(t, *Bricks().fields(t))
    assert_holds(folder / "fields.xdmf", [0.0, 1.0])
    assert (folder / "fields.1.bin").exists()
    more = Bricks().series(folder / "fields.xdmf", append=2.0)
    more.write(2.0, *Bricks().fields(2.0))
    assert_holds(folder / "fields.xdmf", [0.0, 1.0, 2.0])


@pytest.mark.parallel
@needs_pyvista
def test_ranks_may_hold_no_points_and_no_cells(folder):
    n = 8 if comm.rank == comm.size - 1 else 0
    points = Bricks().points[:n]
    cells = [("hexahedron", np.arange(8).reshape(1, 8))] if n else []
    series = XdmfSeries(comm, folder / "fields.xdmf", cells, n)
    series.write(0.0, points, {"displacement": points}, {"stress": np.ones(n // 8)})
    found = read(folder / "fields.xdmf")
    assert np.array_equal(found["0/points"], gathered(points))
    assert found["0/cell/stress"].tolist() == [1.0]


@pytest.mark.parallel
@pytest.mark.parametrize("path", ["/dev/null/fields.xdmf", "/proc/none/fields.xdmf"])
def test_unwritable_path_is_one_sentence_on_all_ranks(path):
    with pytest.raises(OSError) as caught:
        Bricks().series(Path(path))
    assert str(caught.value).startswith(f"cannot write {path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parallel
def test_shape_that_is_wrong_on_one_rank_raises_on_all(folder):
    series = Bricks().series(folder / "fields.xdmf")
    points, point_data, cell_data = Bricks().fields(0.0)
    last = comm.rank == comm.size - 1
    with pytest.raises(ValueError, match="points have shape"):
        series.write(0.0, points[1:] if last else points, point_data, cell_data)
    with pytest.raises(ValueError, match="field 'u' has shape"):
        series.write(0.0, points, {"u": np.ones((len(points), 3 - last))})


@pytest.mark.parallel
@pytest.mark.skipif(comm.size == 1, reason="needs two ranks that can differ")
def test_ranks_must_write_the_same_fields(folder):
    series = Bricks().series(folder / "fields.xdmf")
    points, _, _ = Bricks().fields(0.0)
    with pytest.raises(ValueError, match="the ranks do not write the same fields"):
        series.write(0.0, points, {f"u{comm.rank}": points})


@pytest.mark.parallel
@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (
            [("prism", np.zeros((1, 6), dtype=int))],
            "unknown cell kind 'prism', known are line, triangle",
        ),
        ([("tetrahedron", np.zeros((1, 8), dtype=int))], r"expected \(n, 4\)"),
        ([("triangle", np.array([[0, 1, 10**6]]))], "name points 0 to 1000000"),
        ([("triangle", np.array([[0, -1, 1]]))], "name points -1 to 1"),
    ],
)
def test_wrong_cells_on_one_rank_raise_on_all(folder, cells, message):
    good = [("triangle", np.array([[0, 1, 2]]))]
    with pytest.raises(ValueError, match=message):
        XdmfSeries(comm, folder / "f.xdmf", good if comm.rank else cells, 3)


def test_every_known_kind_is_tested():
    assert set(VTK_TYPES) == set(VERTICES) == set(KINDS) == {kind for kind, _ in Bricks().cells}
