"""Field output: one moving unstructured grid per time, for ParaView and PyVista.

`XdmfSeries` writes two kinds of files, in parallel and without HDF5:

- ``fields.bin``: the numbers, raw arrays one after another, written by MPI-IO;
- ``fields.xdmf``: a small XML that says where each array starts, written by rank 0.

Every time is one ``UnstructuredGrid`` that carries all fields, so that a reader can warp by one of
them and colour by another. Cells of several kinds share that grid (topology "Mixed").

VTK's older reader takes points for unchanged if the text of their ``DataItem`` is, without a look
at its attributes; so this text carries the time, in a comment.

The numbers are handed to the file system before the XML mentions them, and the XML grows by one
write that replaces its closing tags, so that the end of the program at any moment leaves all
finished times readable and the cost of a time does not depend on how many there are. `sync` forces
the data from the system's memory to the disk, as must be before a checkpoint counts.

The readers keep the start of an array in a signed 32-bit number, so that a further file
(``fields.1.bin``, ...) begins once an array would start beyond 2 GiB.
"""

import errno
import functools
import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Literal

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.foundation.files import naming, replace_file, sync_file, sync_folder
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.simulation.observers.mixed_topology import mixed_topology
from turbine_fenicsx.simulation.observers.stored_grids import file_name, stored_grids

_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
_SERIES = '<Grid Name="series" GridType="Collection" CollectionType="Temporal">\n'
_TAIL = "</Grid>\n</Domain>\n</Xdmf>\n"
_MAX_SEEK = 2**31 - 1
_NUMBER_TYPES = {"i": "Int", "f": "Float"}


class XdmfSeries:
    """Time series of fields on one unstructured grid whose points move.

    Points are numbered by rank: those of rank 0 first, then those of rank 1, and so on. Cells of a
    rank follow the order of its blocks, and so must the rows of its cell data.

    Note:
        The constructor and `write` are collective over ``comm``; an error on one rank is raised on
        all. Files are open only inside these calls: there is nothing to close.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        cells: Sequence[tuple[str, NDArray[Any]]],
        n_points: int,
        *,
        point_data: Mapping[str, NDArray[Any]] | None = None,
        cell_data: Mapping[str, NDArray[Any]] | None = None,
        information: Mapping[str, str] | None = None,
        precision: Literal["float32", "float64"] = "float32",
        append: float | None = None,
    ) -> None:
        """Start a new series, or continue one, and write what does not change in time.

        Args:
            comm: Communicator over which the grid is distributed.
            path: XML file, usually ``OUT/fields.xdmf``; missing folders are made.
            cells: Blocks of this rank: kind (a key of `mixed_topology.CELL_KINDS`) and global point
                numbers in VTK order, shape (n, vertices). A rank may hold none.
            n_points: Number of points of this rank.
            point_data: Fields that do not change, shapes (n,) or (n, 3). They are written once and
                shown at every time.
            cell_data: The same in the cells, shapes (m,) or (m, 3); m is the number of cells of
                this rank.
            information: Texts about the series by name, which readers of XDMF pass over.
            precision: Of the real fields. Coordinates are always float64, integers int32.
            append: Continue the series in ``path``: times before this one [s] stay as far as the
                files are intact, later ones are dropped. With None, or if there is no such file, a
                new series begins.

        Raises:
            ValueError: if cells or fields do not fit together.
            FileError: if the files cannot be written.
        """
        self._comm = comm
        self._path = Path(path)
        self._dtype = np.dtype(precision)
        self._head = _head(information or {})
        self._number, self._offset = 0, 0  # of the file that grows, and its size
        self._synced = 0  # number of the first file that may not be on the disk
        self._times = 0
        self._tail_at: int | None = None
        #: last time of an existing series that stays [s]
        self.last_kept: float | None = None

        error: Exception | None = None
        connectivity: NDArray[Any] = np.empty(0, dtype=np.int32)
        n_cells = 0
        try:
            n_total = comm.allreduce(n_points)
            connectivity = mixed_topology(cells, n_total)
            n_cells = sum(len(block) for _, block in cells)
        except ValueError as problem:
            error = problem
        raise_together(comm, error)
        local = (n_points, n_cells, len(connectivity))
        ends = comm.scan(np.array(local, dtype=np.int64))
        totals = comm.bcast(ends, root=comm.size - 1)
        #: per kind of array: rows of this rank, first row of this rank, rows of all ranks
        self._rows = {
            kind: (local[i], int(ends[i]) - local[i], int(totals[i]))
            for i, kind in enumerate(("Node", "Cell", "Topology"))
        }

        try:
            if comm.rank == 0:
                self._open(append)
        except OSError as problem:
            error = problem
        raise_together(comm, error)
        self._number, self._offset, self._times, self.last_kept = comm.bcast(
            (self._number, self._offset, self._times, self.last_kept)
        )
        self._synced = self._number

        static = self._checked(point_data or {}, cell_data or {})
        items = self._write_arrays([("Topology", "", connectivity), *static])
        self._topology = (
            f'<Topology TopologyType="Mixed" NumberOfElements="{self._rows["Cell"][2]}">'
            f"{items[0]}</Topology>\n"
        )
        self._static = _attributes(static, items[1:])

    def write(
        self,
        t: float,
        points: NDArray[Any],
        point_data: Mapping[str, NDArray[Any]] | None = None,
        cell_data: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """Write one time.

        Args:
            t: Time [s].
            points: Current coordinates of the points of this rank, shape (n, 3) [m].
            point_data: Fields at the points of this rank, shapes (n,) or (n, 3).
            cell_data: Fields in the cells of this rank, shapes (m,) or (m, 3).

        Raises:
            ValueError: if a shape does not fit the grid, or the ranks name different fields.
            FileError: if the files cannot be written; earlier times stay readable.
        """
        t = float(t)
        arrays = self._checked(point_data or {}, cell_data or {}, points)
        items = self._write_arrays(arrays)
        error: Exception | None = None
        if self._comm.rank == 0:
            geometry = items[0].replace(">", f"><!-- t = {t!r} s -->", 1)
            grid = (
                f'<Grid Name="mesh" GridType="Uniform"><Time Value="{t!r}"/>\n'
                f'{self._topology}<Geometry GeometryType="XYZ">{geometry}</Geometry>\n'
                f"{_attributes(arrays[1:], items[1:])}{self._static}</Grid>\n"
            )
            try:
                with naming("write", self._path):
                    self._extend_xml(grid)
            except OSError as problem:
                error = problem
        raise_together(self._comm, error)
        self._times += 1

    def sync(self) -> int:
        """Wait until all times are on the disk. Collective.

        Returns:
            How many there are.

        Raises:
            FileError: if the disk refuses, or a file was moved or deleted.
        """
        error: Exception | None = None
        if self._comm.rank == 0:
            try:
                for number in range(self._synced, self._number + 1):
                    sync_file(self._heavy(number))
                if self._times:
                    sync_file(self._path)
                with naming("write", self._path):
                    sync_folder(self._path.parent)
            except OSError as problem:
                error = problem
        raise_together(self._comm, error)
        self._synced = self._number
        return self._times

    def _open(self, append: float | None) -> None:
        """Prepare both files on rank 0; keep the times before ``append``."""
        with naming("write", self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            if append is not None:
                limit = append - 1e-9 * max(1.0, abs(append))
                kept = [grid for grid in stored_grids(self._path) if grid.time < limit]
                if kept:
                    self._times, self.last_kept = len(kept), kept[-1].time
                    self._number, self._offset = max(grid.place for grid in kept)
                    self._replace_xml("".join(grid.text for grid in kept))
                    return
            self._path.unlink(missing_ok=True)
        self._create_heavy()

    def _create_heavy(self) -> None:
        """Begin a file with numbers; what stood there, maybe a link, is removed."""
        heavy = self._heavy(self._number)
        with naming("write", heavy):
            heavy.unlink(missing_ok=True)
            heavy.open("xb").close()

    def _heavy(self, number: int) -> Path:
        """A file with numbers."""
        return self._path.with_name(file_name(self._path.stem, number))

    def _checked(
        self,
        point_data: Mapping[str, NDArray[Any]],
        cell_data: Mapping[str, NDArray[Any]],
        points: NDArray[Any] | None = None,
    ) -> list[tuple[str, str, NDArray[Any]]]:
        """Arrays as (kind, name, numbers as they go to the file), the same list on all ranks."""
        error: Exception | None = None
        arrays = []
        try:
            if points is not None:
                if np.shape(points) != (self._rows["Node"][0], 3):
                    raise ValueError(
                        f"points have shape {np.shape(points)}, "
                        f"expected ({self._rows['Node'][0]}, 3)"
                    )
                arrays.append(("Node", "", np.ascontiguousarray(points, dtype=np.float64)))
            for kind, fields in (("Node", point_data), ("Cell", cell_data)):
                for name, values in fields.items():
                    array = np.asarray(values)
                    n = self._rows[kind][0]
                    if array.shape not in ((n,), (n, 3)):
                        raise ValueError(
                            f"field '{name}' has shape {array.shape}, expected ({n},) or ({n}, 3)"
                        )
                    dtype = np.int32 if array.dtype.kind in "biu" else self._dtype
                    arrays.append((kind, name, np.ascontiguousarray(array, dtype=dtype)))
        except (TypeError, ValueError) as problem:
            error = problem
        layout = [(kind, name, a.shape[1:], a.dtype.str) for kind, name, a in arrays]
        layouts = self._comm.allgather(layout if error is None else None)
        if None not in layouts and any(other != layouts[0] for other in layouts):
            error = ValueError("the ranks do not write the same fields of the same types")
        raise_together(self._comm, error)
        return arrays

    def _write_arrays(self, arrays: Sequence[tuple[str, str, NDArray[Any]]]) -> list[str]:
        """Write arrays one after another, return their ``DataItem`` elements."""
        items = []
        places: dict[int, list[tuple[int, NDArray[Any]]]] = {}
        for kind, _, array in arrays:
            if self._offset > _MAX_SEEK:
                self._number, self._offset = self._number + 1, 0
                self._create_further()
            _, first, total = self._rows[kind]
            row_size = array.itemsize * math.prod(array.shape[1:])
            dimensions = " ".join(str(n) for n in (total, *array.shape[1:]))
            items.append(
                f'<DataItem Format="Binary" NumberType="{_NUMBER_TYPES[array.dtype.kind]}" '
                f'Precision="{array.itemsize}" Endian="{sys.byteorder.capitalize()}" '
                f'Seek="{self._offset}" Dimensions="{dimensions}">'
                f"{escape(self._heavy(self._number).name)}</DataItem>"
            )
            places.setdefault(self._number, []).append((self._offset + first * row_size, array))
            self._offset += total * row_size
        error = None
        for number, group in places.items():
            error = _write_at_all(self._comm, self._heavy(number), group) or error
        raise_together(self._comm, error)
        if self._comm.rank == 0:
            heavy = self._heavy(self._number)
            try:
                with naming("write", heavy):
                    if heavy.stat().st_size < self._offset:
                        raise OSError("some numbers are missing (disk full?)")
            except OSError as problem:
                error = problem
        raise_together(self._comm, error)
        return items

    def _create_further(self) -> None:
        """Begin a further file on rank 0, before any rank writes to it."""
        error: Exception | None = None
        if self._comm.rank == 0:
            try:
                self._create_heavy()
            except OSError as problem:
                error = problem
        raise_together(self._comm, error)

    def _replace_xml(self, grids: str) -> None:
        """Write the whole XML beside the old one, then take its place."""
        replace_file(self._path, (self._head + grids + _TAIL).encode())
        self._tail_at = len((self._head + grids).encode())

    def _extend_xml(self, grid: str) -> None:
        """Put a grid and new closing tags in the place of the closing tags, in one write."""
        if self._tail_at is None:
            self._replace_xml(grid)
            return
        new = (grid + _TAIL).encode()
        with open(self._path, "r+b", buffering=0) as file:
            file.seek(self._tail_at)
            try:
                if file.write(new) != len(new):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            except OSError:
                file.truncate(self._tail_at)
                file.seek(self._tail_at)
                file.write(_TAIL.encode())
                raise
        self._tail_at += len(grid.encode())


def _head(information: Mapping[str, str]) -> str:
    """What stands before the grids."""
    about = "".join(
        f'<Information Name="{escape(name)}" Value="{escape(text)}"/>\n'
        for name, text in information.items()
    )
    return f"{_HEAD}{about}{_SERIES}"


def _attributes(arrays: Sequence[tuple[str, str, NDArray[Any]]], items: Sequence[str]) -> str:
    """``Attribute`` elements of fields and their ``DataItem`` elements."""
    return "".join(
        f'<Attribute Name="{escape(name)}" Center="{kind}" '
        f'AttributeType="{"Scalar" if array.ndim == 1 else "Vector"}">{item}</Attribute>\n'
        for (kind, name, array), item in zip(arrays, items, strict=True)
    )


def _write_at_all(
    comm: MPI.Intracomm, path: Path, arrays: Sequence[tuple[int, NDArray[Any]]]
) -> OSError | None:
    """Write arrays at byte offsets, close the file; return the first error of this rank.

    One rank alone writes an ordinary file, ten times as fast as by MPI-IO. After an error the
    remaining collective calls still happen, because the other ranks make them.
    """
    if comm.size == 1:
        try:
            with open(path, "r+b") as plain:
                for offset, array in arrays:
                    plain.seek(offset)
                    plain.write(array.data)
        except OSError as problem:
            return FileError(f"cannot write {path}: {problem.strerror or problem}")
        return None
    try:
        file = MPI.File.Open(comm, os.fspath(path), MPI.MODE_WRONLY)
    except MPI.Exception as problem:
        return FileError(f"cannot write {path}: {problem}")
    error = None
    calls: list[Callable[[], object]] = [
        functools.partial(file.Write_at_all, offset, array) for offset, array in arrays
    ]
    for call in (*calls, file.Close):
        try:
            call()
        except MPI.Exception as problem:
            error = error or FileError(f"cannot write {path}: {problem}")
    return error
