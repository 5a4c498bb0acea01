"""A time series of fields on one distributed grid whose points move, whatever file it goes to."""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together

VERTICES = {"line": 2, "triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}
"""Kinds of cells, and their numbers of vertices."""

ROOM = 64
"""Times that a file has room for at first, if nobody knows how many will come."""


class FieldRows(NamedTuple):
    """Numbers of this rank as they go to the file.

    Args:
        kind: "Node" or "Cell".
        name: Empty for the coordinates.
    """

    kind: str
    name: str
    values: NDArray[Any]


class Share(NamedTuple):
    """Rows of this rank, the first of them, and those of all ranks."""

    own: int
    first: int
    total: int

    @classmethod
    def of(cls, comm: MPI.Intracomm, own: int) -> Share:
        """The share of each rank. Collective."""
        end = comm.scan(own)
        return cls(own, end - own, comm.bcast(end, root=comm.size - 1))


class GridSeries:
    """Base of the series, which subclasses write to files of one format.

    Points are numbered by rank: those of rank 0 first, then those of rank 1, and so on. Cells of a
    rank follow the order of its blocks, and so must the rows of its cell data.

    Args:
        comm: Communicator over which the grid is distributed.
        path: File, usually ``OUT/fields.xdmf``; missing folders are made.
        cells: Blocks of this rank: kind (a key of `VERTICES`) and global point numbers in VTK
            order, shape (n, vertices). A rank may hold none.
        n_points: Number of points of this rank.
        point_data: Fields that do not change, shapes (n,) or (n, 3). They are written once and
            shown at every time.
        cell_data: Such fields in the cells, shapes (m,) or (m, 3); m is the number of cells of this
            rank.
        information: Texts about the series by name, which other readers pass over.
        precision: Of the real fields. Coordinates are always float64, integers int32.
        append: Continue the series in ``path``: times before this one [s] stay as far as the files
            are intact, later ones are dropped. With None, or if there is no such file, a new series
            begins.
        room: Number of times that a file has room for at first, if its format needs that; it grows.

    Attributes:
        last_kept: Last time of an existing series that is continued [s]; None for a new one.

    Raises:
        ModelError: for cells without a kind or without points, on all ranks.

    Note:
        The constructor and all methods are collective; an error on one rank is raised on all. Files
        are open only inside these calls: there is nothing to close.
    """

    last_kept: float | None

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
        room: int = ROOM,
    ) -> None:
        self._comm, self._path = comm, Path(path)
        self._dtype = np.dtype(precision)
        nodes = Share.of(comm, n_points)
        error: Exception | None = None
        try:
            self._cells = [_check_block(kind, block, nodes.total) for kind, block in cells]
        except ModelError as problem:
            error = problem
        raise_together(comm, error)
        n_cells = sum(len(block) for _, block in self._cells)
        self._shares = {"Node": nodes, "Cell": Share.of(comm, n_cells)}
        self._information, self._room = dict(information or {}), max(room, 1)
        self._static = self._check_fields(point_data, cell_data)
        self._start(append)

    @abstractmethod
    def _start(self, append: float | None) -> None:
        """Start a new series, or continue one, see ``append``."""

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
        self._write(float(t), self._check_fields(point_data, cell_data, points))

    @abstractmethod
    def _write(self, t: float, fields: Sequence[FieldRows]) -> None:
        """Write the coordinates and then the fields of a time."""

    @abstractmethod
    def sync(self) -> int:
        """Wait until all times are on the disk; their number."""

    def finish(self) -> None:
        """Nothing more is written."""

    def _check_fields(
        self,
        point_data: Mapping[str, NDArray[Any]] | None,
        cell_data: Mapping[str, NDArray[Any]] | None,
        points: NDArray[Any] | None = None,
    ) -> list[FieldRows]:
        """The fields, the same list on all ranks, with coordinates first."""
        error: Exception | None = None
        fields = []
        try:
            if points is not None:
                n = self._shares["Node"].own
                if np.shape(points) != (n, 3):
                    raise ModelError(f"points have shape {np.shape(points)}, expected ({n}, 3)")
                fields.append(FieldRows("Node", "", np.ascontiguousarray(points, dtype=np.float64)))
            for kind, group in (("Node", point_data), ("Cell", cell_data)):
                for name, values in (group or {}).items():
                    array = np.asarray(values)
                    n = self._shares[kind].own
                    if array.shape not in ((n,), (n, 3)):
                        raise ModelError(
                            f"field '{name}' has shape {array.shape}, expected ({n},) or ({n}, 3)"
                        )
                    dtype = np.int32 if array.dtype.kind in "biu" else self._dtype
                    fields.append(FieldRows(kind, name, np.ascontiguousarray(array, dtype=dtype)))
        except (TypeError, ValueError) as problem:
            error = problem
        layout = [(f.kind, f.name, f.values.shape[1:], f.values.dtype.str) for f in fields]
        layouts = self._comm.allgather(layout if error is None else None)
        if None not in layouts and any(other != layouts[0] for other in layouts):
            error = ModelError("the ranks do not write the same fields of the same types")
        raise_together(self._comm, error)
        return fields


def _check_block(kind: str, block: NDArray[Any], n_points: int) -> tuple[str, NDArray[np.int64]]:
    """A block of cells whose vertices are there."""
    if kind not in VERTICES:
        raise ModelError(f"unknown cell kind '{kind}', known are {', '.join(VERTICES)}")
    vertices = np.asarray(block, dtype=np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != VERTICES[kind]:
        raise ModelError(
            f"{kind} cells have shape {vertices.shape}, expected (n, {VERTICES[kind]})"
        )
    if vertices.size and not 0 <= vertices.min() <= vertices.max() < n_points:
        raise ModelError(
            f"{kind} cells name points {vertices.min()} to {vertices.max()}, "
            f"there are 0 to {n_points - 1}"
        )
    return kind, vertices
