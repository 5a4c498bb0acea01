"""A series of moving bricks of all kinds of cells, and what programs find in its file."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.records.field_files import open_series
from turbine_fenicsx.records.grid_series import GridSeries

comm = MPI.COMM_WORLD
VTK_TYPES = {"line": 3, "triangle": 5, "quadrilateral": 9, "tetrahedron": 10, "hexahedron": 12}
READER = """
import sys
import numpy as np
import pyvista
from turbine_fenicsx.postprocessing.field_reader import open_grids
reader = open_grids(sys.argv[1])
found = {"times": np.array(reader.times)}
for step in reversed(range(len(reader.times))):
    grid = reader.read(step)
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
    """A stack of cells of all kinds; rank r has r + 1 of each."""

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
            ("line", first + np.array((0, 6))),
        ]
        self.n_cells = 5 * n
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

    def series(self, path: Path, **options) -> GridSeries:
        static = {"part": self.part, "fibre": self.fibre}
        options |= {"cells": self.cells, "n_points": len(self.points), "cell_data": static}
        return open_series(comm, path, **options)

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
    found = read(path)
    if path.suffix == ".xdmf":  # its lines are polylines of two points
        for name in found:
            if name.endswith("/kinds"):
                found[name] = np.where(found[name] == 4, VTK_TYPES["line"], found[name])
    assert_equal(found, times, dtype)


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
