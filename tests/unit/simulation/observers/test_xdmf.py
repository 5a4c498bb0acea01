"""What PyVista and ParaView find in the files of `XdmfSeries`, on any number of ranks.

The readers run in a child process of rank 0, so that VTK and MPI never meet in one process.
"""

import importlib.util
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.simulation.observers.mixed_topology import CELL_KINDS
from turbine_fenicsx.simulation.observers.stored_grids import read_grids
from turbine_fenicsx.simulation.observers.xdmf import XdmfSeries

comm = MPI.COMM_WORLD

VTK_TYPES = {"triangle": 5, "quadrilateral": 9, "tetrahedron": 10, "hexahedron": 12}
READER = """
import sys
import numpy as np
import pyvista
reader = pyvista.get_reader(sys.argv[1])
found = {"times": np.array(reader.time_values)}
for step in reversed(range(len(reader.time_values))):
    reader.set_active_time_point(step)
    grid = reader.read()
    assert isinstance(grid, pyvista.UnstructuredGrid), type(grid)
    found[f"{step}/points"] = grid.points
    found[f"{step}/kinds"] = grid.celltypes
    found[f"{step}/vertices"] = grid.cell_connectivity
    for name in grid.point_data:
        found[f"{step}/point/{name}"] = grid.point_data[name]
    for name in grid.cell_data:
        found[f"{step}/cell/{name}"] = grid.cell_data[name]
np.savez(sys.argv[2], **found)
"""
PARAVIEW_READER = """
import sys
import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy
path = sys.argv[1]
readers = {
    "XDMFReader": simple.XDMFReader(FileNames=[path]),
    "Xdmf3ReaderS": simple.Xdmf3ReaderS(FileName=[path]),
    "Xdmf3ReaderT": simple.Xdmf3ReaderT(FileName=[path]),
    "automatic": simple.OpenDataFile(path),
}
found = {}
for key, reader in readers.items():
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    found[f"{key}/times"] = np.array(times)
    for step in reversed(range(len(times))):
        reader.UpdatePipeline(times[step])
        grid = servermanager.Fetch(reader)
        assert grid.GetClassName() == "vtkUnstructuredGrid", grid.GetClassName()
        here = f"{key}/{step}"
        found[f"{here}/points"] = vtk_to_numpy(grid.GetPoints().GetData()).copy()
        found[f"{here}/kinds"] = vtk_to_numpy(grid.GetCellTypesArray()).copy()
        found[f"{here}/vertices"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).copy()
        for place, data in (("point", grid.GetPointData()), ("cell", grid.GetCellData())):
            for i in range(data.GetNumberOfArrays()):
                array = data.GetArray(i)
                found[f"{here}/{place}/{array.GetName()}"] = vtk_to_numpy(array).copy()
np.savez(sys.argv[2], **found)
"""
needs_pyvista = pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista, which reads back, is missing"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return comm.bcast(tmp_path)


def read(path: Path, reader: str = READER, python: str = sys.executable) -> dict[str, np.ndarray]:
    """All that PyVista or ParaView finds, the same on all ranks."""
    result = None
    if comm.rank == 0:
        out, script = path.with_suffix(".npz"), path.with_name("read.py")
        script.write_text(reader)
        env = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMIX_"))}
        child = subprocess.run(
            [python, str(script), str(path), str(out)],
            capture_output=True,
            text=True,
            env=env,
        )
        result = child.stderr if child.returncode else dict(np.load(out))
    result = comm.bcast(result)
    assert isinstance(result, dict), result
    return result


def gathered(local: np.ndarray) -> np.ndarray:
    return np.concatenate(comm.allgather(local))


class Bricks:
    """A stack of hexahedra, tetrahedra, quadrilaterals and triangles; rank r has r + 1 of each."""

    def __init__(self) -> None:
        n = comm.rank + 1
        brick = np.array(
            [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        )
        self.points = np.concatenate(
            [brick + np.array((3.0 * comm.rank, 0, 2 * i)) for i in range(n)]
        )
        first = comm.scan(len(self.points)) - len(self.points) + 8 * np.arange(n)[:, None]
        self.cells = [
            ("hexahedron", first + np.arange(8)),
            ("quadrilateral", first + np.array((0, 3, 2, 1))),
            ("tetrahedron", first + np.array((0, 1, 2, 5))),
            ("triangle", first + np.array((4, 5, 7))),
        ]
        self.n_cells = 4 * n
        self.fibre = np.tile((0.0, 1.0, comm.rank), (self.n_cells, 1))
        self.part = 10 * comm.rank + np.arange(self.n_cells)

    def fields(self, t: float) -> tuple[np.ndarray, dict, dict]:
        u = np.sin(t + self.points)
        stress = 1e6 * (1 + t) * (1 + np.arange(self.n_cells) + 100 * comm.rank)
        return (
            self.points + u,
            {"displacement": u, "speed": u[:, 0]},
            {"cauchy_stress_norm": stress, "normal": self.fibre + t},
        )

    def series(self, path: Path, **options) -> XdmfSeries:
        static = {"part": self.part, "fibre": self.fibre}
        return XdmfSeries(comm, path, self.cells, len(self.points), cell_data=static, **options)

    def expected(self, t: float, dtype: str = "float32") -> dict[str, np.ndarray]:
        points, point_data, cell_data = self.fields(t)
        wanted = {
            "points": points,
            "kinds": np.concatenate([np.full(len(c), VTK_TYPES[kind]) for kind, c in self.cells]),
            "vertices": np.concatenate([block.ravel() for _, block in self.cells]),
            "cell/part": self.part,
            "cell/fibre": self.fibre.astype(dtype),
        }
        wanted |= {f"point/{name}": values.astype(dtype) for name, values in point_data.items()}
        wanted |= {f"cell/{name}": values.astype(dtype) for name, values in cell_data.items()}
        return {name: gathered(values) for name, values in wanted.items()}


def assert_holds(path: Path, times: list[float], dtype: str = "float32") -> None:
    """The series has these times and no others, and every number of every field is right."""
    assert_equal(read(path), times, dtype)


def assert_equal(found: dict[str, np.ndarray], times: list[float], dtype: str) -> None:
    bricks = Bricks()
    assert found["times"].tolist() == times
    for step, t in enumerate(times):
        expected = bricks.expected(t, dtype)
        names = {name.split("/", 1)[1] for name in found if name.startswith(f"{step}/")}
        assert names == set(expected)
        for name, values in expected.items():
            assert np.array_equal(found[f"{step}/{name}"], values), (step, name)
            if name.startswith("point/"):
                assert found[f"{step}/{name}"].dtype == dtype


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


@pytest.mark.parametrize("path", ["/dev/null/fields.xdmf", "/proc/none/fields.xdmf"])
def test_unwritable_path_is_one_sentence_on_all_ranks(path):
    with pytest.raises(OSError) as caught:
        Bricks().series(Path(path))
    assert str(caught.value).startswith(f"cannot write {path}: ")
    assert "\n" not in str(caught.value)


def test_shape_that_is_wrong_on_one_rank_raises_on_all(folder):
    series = Bricks().series(folder / "fields.xdmf")
    points, point_data, cell_data = Bricks().fields(0.0)
    last = comm.rank == comm.size - 1
    with pytest.raises(ValueError, match="points have shape"):
        series.write(0.0, points[1:] if last else points, point_data, cell_data)
    with pytest.raises(ValueError, match="field 'u' has shape"):
        series.write(0.0, points, {"u": np.ones((len(points), 3 - last))})


@pytest.mark.skipif(comm.size == 1, reason="needs two ranks that can differ")
def test_ranks_must_write_the_same_fields(folder):
    series = Bricks().series(folder / "fields.xdmf")
    points, _, _ = Bricks().fields(0.0)
    with pytest.raises(ValueError, match="the ranks do not write the same fields"):
        series.write(0.0, points, {f"u{comm.rank}": points})


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([("prism", np.zeros((1, 6), dtype=int))], "unknown cell kind 'prism', known are triangle"),
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
    assert set(VTK_TYPES) == set(CELL_KINDS) == {kind for kind, _ in Bricks().cells}
