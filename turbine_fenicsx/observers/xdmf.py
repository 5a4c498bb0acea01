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
finished times readable and the cost of a time does not depend on how many there are. (Nothing
forces the data from the system's memory to the disk: that would cost more than the rest and
helps against a power failure only.)

The readers keep the start of an array in a signed 32-bit number, so that a further file
(``fields.1.bin``, ...) begins once an array would start beyond 2 GiB.
"""

import errno
import functools
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Literal

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.parallel import raise_together

CELL_KINDS: dict[str, tuple[int, int]] = {
    "triangle": (4, 3),
    "quadrilateral": (5, 4),
    "tetrahedron": (6, 4),
    "hexahedron": (9, 8),
}
"""Cell kind to (XDMF number of the kind, number of vertices)."""

_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
_SERIES = '<Grid Name="series" GridType="Collection" CollectionType="Temporal">\n'
_TAIL = "</Grid>\n</Domain>\n</Xdmf>\n"
_GRID = re.compile(r'<Grid Name="mesh".*?</Grid>\n', re.DOTALL)
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
            cells: Blocks of this rank: kind (a key of `CELL_KINDS`) and global point numbers in
                VTK order, shape (n, vertices). A rank may hold none.
            n_points: Number of points of this rank.
            point_data: Fields that do not change, shapes (n,) or (n, 3). They are written once and
                shown at every time.
            cell_data: The same in the cells, shapes (m,) or (m, 3); m is the number of cells of
                this rank.
            information: Texts about the series by name, which readers of XDMF pass over.
            precision: Of the real fields. Coordinates are always float64, integers int32.
            append: Continue the series in ``path``: times before this one [s] stay, later ones
                are dropped. With None, or if there is no such file, a new series begins.

        Raises:
            ValueError: if cells or fields do not fit together.
            OSError: if the files cannot be written or continued.
        """
        self._comm = comm
        self._path = Path(path)
        self._dtype = np.dtype(precision)
        about = "".join(
            f'<Information Name="{escape(name)}" Value="{escape(text)}"/>\n'
            for name, text in (information or {}).items()
        )
        self._head = f"{_HEAD}{about}{_SERIES}"
        self._file = f"{self._path.stem}.bin"
        self._offset = 0
        self._tail_at: int | None = None
        #: last time of an existing series that stays [s]
        self.last_kept: float | None = None

        error: Exception | None = None
        connectivity: NDArray[Any] = np.empty(0, dtype=np.int32)
        n_cells = 0
        try:
            n_total = comm.allreduce(n_points)
            connectivity = _connectivity(cells, n_total)
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
            error = OSError(f"cannot write {self._path}: {problem.strerror or problem}")
        except (SyntaxError, ValueError, LookupError):
            error = OSError(f"cannot continue {self._path}: it was not written by this program")
        raise_together(comm, error)
        self._file, self._offset, self.last_kept = comm.bcast(
            (self._file, self._offset, self.last_kept)
        )

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
            OSError: if the files cannot be written; earlier times stay readable.
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
                self._extend_xml(grid)
            except OSError as problem:
                error = OSError(f"cannot write {self._path}: {problem.strerror or problem}")
        raise_together(self._comm, error)

    def _open(self, append: float | None) -> None:
        """Prepare both files on rank 0; keep the times before ``append``."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        if append is not None and self._path.exists():
            text = self._path.read_text(encoding="utf-8")
            limit = append - 1e-9 * max(1.0, abs(append))
            kept = []
            for grid in _GRID.findall(text):
                node = ElementTree.fromstring(grid)
                times = [float(time.attrib["Value"]) for time in node.iter("Time")]
                if times[0] < limit:
                    kept.append(grid)
                    self.last_kept = times[0]
                    self._reserve(node)
            if kept:
                self._replace_xml("".join(kept))
                return
        self._path.unlink(missing_ok=True)
        self._path.with_name(self._file).write_bytes(b"")

    def _reserve(self, grid: ElementTree.Element) -> None:
        """Move the place for new arrays behind those of a grid that stays."""
        for item in grid.iter("DataItem"):
            name = (item.text or "").strip()
            size = math.prod(int(n) for n in item.attrib["Dimensions"].split())
            end = int(item.attrib["Seek"]) + size * int(item.attrib["Precision"])
            heavy = self._path.with_name(name)
            if not heavy.exists() or heavy.stat().st_size < end:
                raise OSError(f"{heavy} is missing or too short, the series cannot be continued")
            place = (self._number_of(name), end)
            if place > (self._number_of(self._file), self._offset):
                self._file, self._offset = name, end

    def _number_of(self, name: str) -> int:
        """Number of a heavy file: 0 for ``fields.bin``, 1 for ``fields.1.bin``."""
        return 0 if name == f"{self._path.stem}.bin" else int(name.split(".")[-2])

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
        places: dict[str, list[tuple[int, NDArray[Any]]]] = {}
        for kind, _, array in arrays:
            if self._offset > _MAX_SEEK:
                self._file = f"{self._path.stem}.{self._number_of(self._file) + 1}.bin"
                self._offset = 0
            _, first, total = self._rows[kind]
            row_size = array.itemsize * math.prod(array.shape[1:])
            dimensions = " ".join(str(n) for n in (total, *array.shape[1:]))
            items.append(
                f'<DataItem Format="Binary" NumberType="{_NUMBER_TYPES[array.dtype.kind]}" '
                f'Precision="{array.itemsize}" Endian="{sys.byteorder.capitalize()}" '
                f'Seek="{self._offset}" Dimensions="{dimensions}">{escape(self._file)}</DataItem>'
            )
            places.setdefault(self._file, []).append((self._offset + first * row_size, array))
            self._offset += total * row_size
        error = None
        for name, group in places.items():
            error = _write_at_all(self._comm, self._path.with_name(name), group) or error
        raise_together(self._comm, error)
        if self._comm.rank == 0:
            heavy = self._path.with_name(self._file)
            try:
                if heavy.stat().st_size < self._offset:
                    raise OSError("some numbers are missing (disk full?)")
            except OSError as problem:
                error = OSError(f"cannot write {heavy}: {problem.strerror or problem}")
        raise_together(self._comm, error)
        return items

    def _replace_xml(self, grids: str) -> None:
        """Write the whole XML beside the old one, then take its place."""
        temporary = self._path.with_name(self._path.name + ".new")
        temporary.write_text(self._head + grids + _TAIL, encoding="utf-8")
        os.replace(temporary, self._path)
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


def _connectivity(cells: Sequence[tuple[str, NDArray[Any]]], n_points: int) -> NDArray[np.int32]:
    """Cells as XDMF wants a mixed topology: number of the kind, vertices, number of the kind, ...

    Raises:
        ValueError: if a kind is unknown, a shape is wrong or a point does not exist.
    """
    parts = [np.empty(0, dtype=np.int32)]
    for kind, block in cells:
        if kind not in CELL_KINDS:
            raise ValueError(f"unknown cell kind '{kind}', known are {', '.join(CELL_KINDS)}")
        number, n_vertices = CELL_KINDS[kind]
        vertices = np.asarray(block)
        if vertices.ndim != 2 or vertices.shape[1] != n_vertices:
            raise ValueError(
                f"{kind} cells have shape {vertices.shape}, expected (n, {n_vertices})"
            )
        if vertices.size and not 0 <= vertices.min() <= vertices.max() < n_points:
            raise ValueError(
                f"{kind} cells name points {vertices.min()} to {vertices.max()}, "
                f"there are 0 to {n_points - 1}"
            )
        table = np.full((len(vertices), n_vertices + 1), number, dtype=np.int32)
        table[:, 1:] = vertices
        parts.append(table.ravel())
    return np.concatenate(parts)


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
            with open(path, "r+b" if path.exists() else "wb") as plain:
                for offset, array in arrays:
                    plain.seek(offset)
                    plain.write(array.data)
        except OSError as problem:
            return OSError(f"cannot write {path}: {problem.strerror or problem}")
        return None
    try:
        file = MPI.File.Open(comm, os.fspath(path), MPI.MODE_WRONLY | MPI.MODE_CREATE)
    except MPI.Exception as problem:
        return OSError(f"cannot write {path}: {problem}")
    error = None
    calls: list[Callable[[], object]] = [
        functools.partial(file.Write_at_all, offset, array) for offset, array in arrays
    ]
    for call in (*calls, file.Close):
        try:
            call()
        except MPI.Exception as problem:
            error = error or OSError(f"cannot write {path}: {problem}")
    return error
