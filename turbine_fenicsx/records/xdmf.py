"""Field output: one moving unstructured grid per time, for ParaView and PyVista.

`XdmfSeries` writes two kinds of files, in parallel and without HDF5:

- ``fields.bin``: the numbers, raw arrays one after another, written by MPI-IO;
- ``fields.xdmf``: a small XML that says where each array starts, written by rank 0.

Every time is one ``UnstructuredGrid`` that carries all fields, so that a reader can warp by one of
them and colour by another. Cells of several kinds share that grid (topology "Mixed").

VTK's older reader takes points for unchanged if the text of their ``DataItem`` is, without a look
at its attributes; so this text carries the time, in a comment.

The numbers are handed to the file system before the XML mentions them, and the XML grows by one
write that replaces its closing tags. So all finished times stay readable whenever the program ends,
and the cost of a time does not depend on how many there are. `sync` forces the data from the
system's memory to the disk, as must be before a checkpoint counts.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Literal

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.files import name_file_in_errors, replace_file, sync_file
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together
from turbine_fenicsx.records.number_files import NumberFiles, Rows
from turbine_fenicsx.records.stored_grids import read_grids

CELL_KINDS: dict[str, tuple[tuple[int, ...], int]] = {
    "line": ((2, 2), 2),
    "triangle": ((4,), 3),
    "quadrilateral": ((5,), 4),
    "tetrahedron": ((6,), 4),
    "hexahedron": ((9,), 8),
}
"""Cell kind to what stands before its vertices, XDMF's number of the kind and for lines the number
of vertices, and their number."""


def mixed_topology(cells: Sequence[tuple[str, NDArray[Any]]], n_points: int) -> NDArray[np.int32]:
    """Cells as XDMF wants a mixed topology: number of the kind, its vertices, and so on."""
    parts = [np.empty(0, dtype=np.int32)]
    for kind, block in cells:
        if kind not in CELL_KINDS:
            raise ModelError(f"unknown cell kind '{kind}', known are {', '.join(CELL_KINDS)}")
        head, n_vertices = CELL_KINDS[kind]
        vertices = np.asarray(block)
        if vertices.ndim != 2 or vertices.shape[1] != n_vertices:
            raise ModelError(
                f"{kind} cells have shape {vertices.shape}, expected (n, {n_vertices})"
            )
        if vertices.size and not 0 <= vertices.min() <= vertices.max() < n_points:
            raise ModelError(
                f"{kind} cells name points {vertices.min()} to {vertices.max()}, "
                f"there are 0 to {n_points - 1}"
            )
        table = np.empty((len(vertices), len(head) + n_vertices), dtype=np.int32)
        table[:, : len(head)], table[:, len(head) :] = head, vertices
        parts.append(table.ravel())
    return np.concatenate(parts)


_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
_SERIES = '<Grid Name="series" GridType="Collection" CollectionType="Temporal">\n'
_TAIL = "</Grid>\n</Domain>\n</Xdmf>\n"


class XdmfSeries:
    """Time series of fields on one unstructured grid whose points move.

    Points are numbered by rank: those of rank 0 first, then those of rank 1, and so on. Cells of a
    rank follow the order of its blocks, and so must the rows of its cell data.

    Attributes:
        last_kept: Last time of an existing series that is continued [s]; None for a new one.

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
            cells: Blocks of this rank: kind (a key of `CELL_KINDS`) and global point
                numbers in VTK order, shape (n, vertices). A rank may hold none.
            n_points: Number of points of this rank.
            point_data: Fields that do not change, shapes (n,) or (n, 3). They are written once and
                shown at every time.
            cell_data: Such fields in the cells, shapes (m,) or (m, 3); m is the number of cells of
                this rank.
            information: Texts about the series by name, which readers of XDMF pass over.
            precision: Of the real fields. Coordinates are always float64, integers int32.
            append: Continue the series in ``path``: times before this one [s] stay as far as the
                files are intact, later ones are dropped. With None, or if there is no such file, a
                new series begins.
        """
        self._comm, self._path = comm, Path(path)
        self._dtype = np.dtype(precision)
        self._head = _format_head(information or {})
        self._tail_at: int | None = None
        connectivity = self._count(cells, n_points)
        self._times, self.last_kept, place = on_rank0(comm, lambda: self._open(append))
        self._numbers = NumberFiles(comm, self._path, place)
        static = self._check_arrays(point_data or {}, cell_data or {})
        items = self._write_arrays([("Topology", "", connectivity), *static])
        self._topology = (
            f'<Topology TopologyType="Mixed" NumberOfElements="{self._rows["Cell"][2]}">'
            f"{items[0]}</Topology>\n"
        )
        self._static = _format_attributes(static, items[1:])

    def _count(self, cells: Sequence[tuple[str, NDArray[Any]]], n_points: int) -> NDArray[np.int32]:
        """Count points and cells of all ranks; the cells of this rank as a mixed topology."""
        error: Exception | None = None
        connectivity = np.empty(0, dtype=np.int32)
        n_total = self._comm.allreduce(n_points)
        try:
            connectivity = mixed_topology(cells, n_total)
        except ValueError as problem:
            error = problem
        raise_together(self._comm, error)
        local = (n_points, sum(len(block) for _, block in cells), len(connectivity))
        ends = self._comm.scan(np.array(local, dtype=np.int64))
        totals = self._comm.bcast(ends, root=self._comm.size - 1)
        #: per kind of array: rows of this rank, first row of this rank, rows of all ranks
        self._rows = {
            kind: (local[i], int(ends[i]) - local[i], int(totals[i]))
            for i, kind in enumerate(("Node", "Cell", "Topology"))
        }
        return connectivity

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
        """
        t = float(t)
        arrays = self._check_arrays(point_data or {}, cell_data or {}, points)
        items = self._write_arrays(arrays)
        geometry = items[0].replace(">", f"><!-- t = {t!r} s -->", 1)
        grid = (
            f'<Grid Name="mesh" GridType="Uniform"><Time Value="{t!r}"/>\n'
            f'{self._topology}<Geometry GeometryType="XYZ">{geometry}</Geometry>\n'
            f"{_format_attributes(arrays[1:], items[1:])}{self._static}</Grid>\n"
        )
        on_rank0(self._comm, lambda: self._extend_xml(grid))
        self._times += 1

    def sync(self) -> int:
        """Wait until all times are on the disk. Collective."""
        self._numbers.sync()
        if self._times:
            on_rank0(self._comm, lambda: sync_file(self._path))
        return self._times

    def _open(self, append: float | None) -> tuple[int, float | None, tuple[int, int] | None]:
        """Prepare the XML on rank 0, with the times before ``append``.

        Returns:
            Number of these times, the last of them, and the end of their numbers; 0 and None if
            there are none.
        """
        with name_file_in_errors("write", self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            if append is not None:
                limit = append - 1e-9 * max(1.0, abs(append))
                kept = [grid for grid in read_grids(self._path) if grid.time < limit]
                if kept:
                    self._replace_xml("".join(grid.text for grid in kept))
                    return len(kept), kept[-1].time, max(grid.place for grid in kept)
            self._path.unlink(missing_ok=True)
        return 0, None, None

    def _check_arrays(
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
                    raise ModelError(
                        f"points have shape {np.shape(points)}, "
                        f"expected ({self._rows['Node'][0]}, 3)"
                    )
                arrays.append(("Node", "", np.ascontiguousarray(points, dtype=np.float64)))
            for kind, fields in (("Node", point_data), ("Cell", cell_data)):
                for name, values in fields.items():
                    array = np.asarray(values)
                    n = self._rows[kind][0]
                    if array.shape not in ((n,), (n, 3)):
                        raise ModelError(
                            f"field '{name}' has shape {array.shape}, expected ({n},) or ({n}, 3)"
                        )
                    dtype = np.int32 if array.dtype.kind in "biu" else self._dtype
                    arrays.append((kind, name, np.ascontiguousarray(array, dtype=dtype)))
        except (TypeError, ValueError) as problem:
            error = problem
        layout = [(kind, name, a.shape[1:], a.dtype.str) for kind, name, a in arrays]
        layouts = self._comm.allgather(layout if error is None else None)
        if None not in layouts and any(other != layouts[0] for other in layouts):
            error = ModelError("the ranks do not write the same fields of the same types")
        raise_together(self._comm, error)
        return arrays

    def _write_arrays(self, arrays: Sequence[tuple[str, str, NDArray[Any]]]) -> list[str]:
        """Write arrays of this rank, return their ``DataItem`` elements."""
        return self._numbers.append(
            [Rows(array, *self._rows[kind][1:]) for kind, _, array in arrays]
        )

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
        with name_file_in_errors("write", self._path), open(self._path, "r+b", buffering=0) as file:
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


def _format_head(information: Mapping[str, str]) -> str:
    """Text before the grids."""
    about = "".join(
        f'<Information Name="{escape(name)}" Value="{escape(text)}"/>\n'
        for name, text in information.items()
    )
    return f"{_HEAD}{about}{_SERIES}"


def _format_attributes(
    arrays: Sequence[tuple[str, str, NDArray[Any]]], items: Sequence[str]
) -> str:
    """``Attribute`` elements of fields and their ``DataItem`` elements."""
    return "".join(
        f'<Attribute Name="{escape(name)}" Center="{kind}" '
        f'AttributeType="{"Scalar" if array.ndim == 1 else "Vector"}">{item}</Attribute>\n'
        for (kind, name, array), item in zip(arrays, items, strict=True)
    )
