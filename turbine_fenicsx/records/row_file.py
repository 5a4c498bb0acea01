"""A text file that grows by one line per step."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TextIO

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import FileError
from turbine_fenicsx.foundation.files import (
    name_file_in_errors,
    read_regular,
    replace_file,
    sync_folder,
)
from turbine_fenicsx.foundation.parallel import on_rank0


class RowFile:
    """Rank 0 writes, and flushes after every line, so that other programs can follow.

    Args:
        path: The file; it is replaced immediately, so that a crash here loses no rows of an old
            one.
        first: Returns the first lines; called on rank 0 before the old file is replaced.

    Note:
        All methods except `close` are collective.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        first: Callable[[], Iterable[str]],
    ) -> None:
        self._comm, self._path = comm, Path(path)
        self._file: TextIO | None = None
        self._lines = 0

        def create() -> None:
            lines = list(first())
            replace_file(path, "".join(f"{line}\n" for line in lines).encode())
            with name_file_in_errors("write", path):
                self._file = self._path.open("a", encoding="utf-8", newline="\n")
            self._lines = len(lines)

        on_rank0(comm, create)

    def write(self, line: str) -> None:
        """Append one line."""

        def append() -> None:
            assert self._file is not None
            with name_file_in_errors("write", self._path):
                self._file.write(f"{line}\n")
                self._file.flush()
            self._lines += 1

        on_rank0(self._comm, append)

    def sync(self) -> int:
        """Wait until all lines are on the disk, under the name they should have there.

        Returns:
            How many lines the file holds, on all ranks.
        """

        def sync() -> int:
            assert self._file is not None
            with name_file_in_errors("write", self._path):
                os.fsync(self._file.fileno())
                try:
                    there = os.path.samestat(os.fstat(self._file.fileno()), os.stat(self._path))
                except FileNotFoundError:
                    there = False
                if not there:
                    raise FileError(
                        f"cannot write {self._path}: it was moved or deleted during the run"
                    )
                sync_folder(self._path.parent)
            return self._lines

        return on_rank0(self._comm, sync)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            with name_file_in_errors("write", self._path):
                self._file.close()


def join_columns(names: Sequence[str]) -> str:
    """The head of a table of comma-separated numbers; names with commas or quotes are quoted."""
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow(names)
    return text.getvalue()


def write_table(
    path: str | os.PathLike[str], head: Sequence[str], rows: Iterable[Sequence[str]]
) -> None:
    """Write a table of comma-separated texts, whole or not at all."""
    lines = [join_columns(row) for row in (head, *rows)]
    replace_file(path, "".join(f"{line}\n" for line in lines).encode())


def split_columns(head: str) -> list[str]:
    """The names in such a head."""
    return next(csv.reader([head]), [])


def read_rows(path: str | os.PathLike[str], head: int, width: int, separator: str) -> list[str]:
    """The rows of a file that are whole: rows of numbers, as many as there are columns.

    A crash may have cut the last one off, and a power cut left zeros in the place of some.

    Args:
        path: The file; a missing one has no rows.
    """
    if not Path(path).exists():
        return []
    with name_file_in_errors("read", path):
        text = read_regular(path).decode("utf-8", "replace")
    return [row for row in text.split("\n")[head:-1] if _is_whole(row.split(separator), width)]


def select_rows(rows: Iterable[str], time: float, separator: str) -> list[str]:
    """The rows up to a time [s], which is their first number."""
    return [row for row in rows if float(row.split(separator, 1)[0]) <= time]


def _is_whole(cells: list[str], width: int) -> bool:
    """Whether the cells of a row are numbers, and none is missing."""
    try:
        return len(cells) == width and len([float(cell) for cell in cells]) == width
    except ValueError:
        return False
