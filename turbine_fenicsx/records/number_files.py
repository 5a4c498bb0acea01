"""Raw arrays one after another, in files that all ranks write (``fields.bin``, ``fields.1.bin``).

The readers of XDMF keep the start of an array in a signed 32-bit number, so that a further file
begins once an array would start beyond 2 GiB.
"""

from __future__ import annotations

import functools
import math
import os
import sys
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from mpi4py import MPI

from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.foundation.files import name_file_in_errors, sync_file, sync_folder
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together
from turbine_fenicsx.records.stored_grids import file_name

_MAX_SEEK = 2**31 - 1
_NUMBER_TYPES = {"i": "Int", "f": "Float"}


class Rows(NamedTuple):
    """Rows of an array that is distributed over the ranks.

    Args:
        first: Number of the first of them.
        total: Number of all rows.
    """

    values: NDArray[Any]
    first: int
    total: int


class NumberFiles:
    """Files of raw numbers that grow, open only inside the calls.

    Args:
        path: The XDMF file that they belong to; its name without suffix is theirs.
        place: Number of an existing file that is continued, and where [bytes]; None begins the
            first.

    Note:
        The constructor and all methods are collective; an error on one rank is raised on all.
    """

    def __init__(self, comm: MPI.Intracomm, path: Path, place: tuple[int, int] | None) -> None:
        self._comm, self._xdmf = comm, path
        self._number, self._size = place or (0, 0)
        self._synced = self._number  # number of the first file that may not be on the disk
        if place is None:
            on_rank0(comm, self._create)

    def append(self, arrays: Sequence[Rows]) -> list[str]:
        """Write arrays one after another."""
        items = []
        places: dict[int, list[tuple[int, NDArray[Any]]]] = {}
        for values, first, total in arrays:
            if self._size > _MAX_SEEK:
                self._number, self._size = self._number + 1, 0
                on_rank0(self._comm, self._create)
            row_size = values.itemsize * math.prod(values.shape[1:])
            dimensions = " ".join(str(n) for n in (total, *values.shape[1:]))
            items.append(
                f'<DataItem Format="Binary" NumberType="{_NUMBER_TYPES[values.dtype.kind]}" '
                f'Precision="{values.itemsize}" Endian="{sys.byteorder.capitalize()}" '
                f'Seek="{self._size}" Dimensions="{dimensions}">'
                f"{escape(self._path(self._number).name)}</DataItem>"
            )
            places.setdefault(self._number, []).append((self._size + first * row_size, values))
            self._size += total * row_size
        error = None
        for number, group in places.items():
            error = write_at_all(self._comm, self._path(number), group) or error
        raise_together(self._comm, error)
        on_rank0(self._comm, self._check_size)
        return items

    def sync(self) -> None:
        """Wait until all numbers are on the disk."""
        on_rank0(self._comm, self._sync)
        self._synced = self._number

    def _sync(self) -> None:
        for number in range(self._synced, self._number + 1):
            sync_file(self._path(number))
        with name_file_in_errors("write", self._xdmf):
            sync_folder(self._xdmf.parent)

    def _create(self) -> None:
        """Begin a file; what stood there, maybe a link, is removed."""
        path = self._path(self._number)
        with name_file_in_errors("write", path):
            path.unlink(missing_ok=True)
            path.open("xb").close()

    def _check_size(self) -> None:
        path = self._path(self._number)
        with name_file_in_errors("write", path):
            if path.stat().st_size < self._size:
                raise OSError("some numbers are missing (disk full?)")

    def _path(self, number: int) -> Path:
        return self._xdmf.with_name(file_name(self._xdmf.stem, number))


def write_at_all(
    comm: MPI.Intracomm, path: Path, arrays: Sequence[tuple[int, NDArray[Any]]]
) -> OSError | None:
    """Write arrays at byte offsets of an existing file; the first error of this rank. Collective.

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
