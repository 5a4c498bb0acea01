"""A text file that grows by a line a step."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TextIO

from mpi4py import MPI

from turbine_fenicsx.parallel import on_rank0


class RowFile:
    """Rank 0 writes, and flushes after every line, so that other programs can follow.

    Args:
        comm: Communicator.
        path: The file; it is replaced at once, so that a crash here loses no rows of an old one.
        first: Returns the first lines; called on rank 0 before the old file is replaced.

    Raises:
        OSError: if the file cannot be written, on all ranks.

    Note:
        All methods but `close` are collective.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        first: Callable[[], Iterable[str]],
    ) -> None:
        """Write the first lines."""
        self._comm = comm
        self._file: TextIO | None = None

        def create() -> None:
            lines = first()
            temporary = Path(f"{os.fspath(path)}.tmp")
            self._file = temporary.open("w", encoding="utf-8", newline="\n")
            self._file.writelines(f"{line}\n" for line in lines)
            self._file.flush()
            os.replace(temporary, path)

        on_rank0(comm, create)

    def write(self, line: str) -> None:
        """Append one line."""

        def append() -> None:
            assert self._file is not None
            self._file.write(f"{line}\n")
            self._file.flush()

        on_rank0(self._comm, append)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
