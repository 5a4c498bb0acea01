"""The motion of a run with reduced bodies in two files: rows of numbers, and what they mean.

``motion.bin`` has rows of float64 in the order of bytes of the machine. A row begins with the time
[s], then come the coordinates q of the rigid bodies and their rates, 12 for each body: position and
three directors. Vectors z and their velocities follow for each reduced body, one copy after
another. ``motion.json`` says which bodies these are and which functions their vectors belong to.
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelWarning
from turbine_fenicsx.foundation.files import (
    name_file_in_errors,
    open_regular,
    replace_file,
    sync_file,
)
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array

VERSION = 1
"""Version of the files."""

BLOCK = 2**24
"""Bytes that are read together."""

SAME_TIME = 1e-9
"""Relative difference of times that are one."""


@dataclass(frozen=True)
class MovedBody:
    """A reduced body whose motion is stored.

    Args:
        copies: Number of copies.
        vectors: Number of vectors of a copy.
        meaning: Hash of the basis that the vectors belong to.
    """

    name: str
    copies: int
    vectors: int
    meaning: str

    @property
    def width(self) -> int:
        """Numbers of its vectors in a row."""
        return 3 * self.copies * self.vectors


@dataclass(frozen=True, eq=False)
class StoredRows:
    """Numbers of a body in the rows of a motion, read when they are asked for.

    ``rows[k]``, ``rows[k:l]`` and ``rows[k:l, copy]`` are arrays, as of one of the same shape.

    Args:
        path: ``motion.bin``.
        width: Numbers in a row of the file.
        first: The first of them that is the body's.
        shape: Shape of all: rows, copies, vectors, 3.
    """

    path: Path
    width: int
    first: int
    shape: tuple[int, int, int, int]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Array:
        rows, *more = key if isinstance(key, tuple) else (key,)
        if isinstance(rows, slice):
            begin, end, step = rows.indices(len(self))
            return self._read(begin, max(begin, end))[(slice(None, None, step), *more)]
        row = range(len(self))[rows]
        found: Array = self._read(row, row + 1)[(0, *more)]
        return found

    def _read(self, begin: int, end: int) -> Array:
        """Rows one after another, shape (rows, copies, vectors, 3)."""
        size = 8 * self.width * (end - begin)
        with name_file_in_errors("read", self.path), open_regular(self.path) as file:
            file.seek(8 * self.width * begin)
            content = file.read(size)
        if len(content) < size:
            raise InputError(f"{str(self.path)!r} has become shorter since it was opened")
        block = np.frombuffer(content).reshape(end - begin, self.width)
        own = block[:, self.first : self.first + int(np.prod(self.shape[1:]))]
        return np.asarray(own.reshape(len(own), *self.shape[1:]))


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a run.

    Args:
        times: Shape (rows,) [s].
        q: Coordinates of the rigid bodies, shape (rows, 12 bodies).
        q_dot: Their rates.
        rigid: Names of the rigid bodies.
        bodies: The reduced bodies.
        vectors: Vectors z of each by its name, shape (rows, copies, n, 3).
        velocities: Their velocities.
    """

    times: Array
    q: Array
    q_dot: Array
    rigid: tuple[str, ...]
    bodies: tuple[MovedBody, ...]
    vectors: dict[str, StoredRows]
    velocities: dict[str, StoredRows]


class MotionFile:
    """The files of a motion that grows, open only inside the calls; rank 0 writes.

    Args:
        keep: Time before which rows of existing files are kept [s]; None begins new files.

    Note:
        The constructor and all methods are collective.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: Path,
        rigid: Sequence[str],
        bodies: Sequence[MovedBody],
        keep: float | None,
    ) -> None:
        self._comm, self._path = comm, path
        self._head = describe_rows(rigid, bodies)
        self.rows = on_rank0(comm, partial(self._open, keep))

    def _open(self, keep: float | None) -> int:
        """Begin new files, or keep the rows before a time; their number."""
        rows = 0
        if keep is not None and self._path.exists():
            head, width = _read_head(self._path, self._head)
            if head != self._head:
                raise InputError(f"{str(self._path)!r} holds the motion of other bodies")
            times = _scan(self._path, width, 1)[0][:, 0]
            rows = int(np.sum(times < keep - SAME_TIME * max(1.0, abs(keep))))
            with name_file_in_errors("write", self._path):
                os.truncate(self._path, rows * 8 * width)
        else:
            replace_file(self._path, b"")
        replace_file(_head_of(self._path), (json.dumps(self._head, indent=2) + "\n").encode())
        return rows

    def append(self, row: Array) -> None:
        """Write a row, which rank 0 has."""

        def write() -> None:
            with name_file_in_errors("write", self._path), self._path.open("ab") as file:
                file.write(np.ascontiguousarray(row, dtype=float).tobytes())

        on_rank0(self._comm, write)
        self.rows += 1

    def sync(self) -> int:
        """Wait until all rows are on the disk; their number."""
        on_rank0(self._comm, lambda: sync_file(self._path))
        return self.rows


def read_motion(path: str | os.PathLike[str]) -> Motion:
    """Read the motion of a run.

    Args:
        path: ``motion.bin`` in an output folder.

    Raises:
        InputError: for files that are not there, or not a motion.

    Warns:
        ModelWarning: if rows are left out, as a power cut leaves them: cut, with zeros or with nan.
    """
    path = Path(path)
    head, width = _read_head(path)
    rigid, bodies = tuple(head["rigid_bodies"]), tuple(MovedBody(**b) for b in head["bodies"])
    leading = 1 + 24 * len(rigid)
    first, whole = _scan(path, width, leading)
    if not whole:
        warnings.warn(
            f"{os.fspath(path)} is whole up to row {len(first)}; those from there on are left out, "
            "which are cut, hold no numbers, or have times that do not grow",
            ModelWarning,
            stacklevel=2,
        )
    times, q, q_dot = np.split(first, [1, 1 + 12 * len(rigid)], axis=1)
    found: tuple[dict[str, StoredRows], dict[str, StoredRows]] = ({}, {})
    for b in bodies:
        for each in found:
            each[b.name] = StoredRows(path, width, leading, (len(first), b.copies, b.vectors, 3))
            leading += b.width
    return Motion(times[:, 0], q, q_dot, rigid, bodies, *found)


def count_rows(path: Path, before: float, head: dict[str, Any]) -> int:
    """Number of good rows before a time in files that may be missing.

    Args:
        before: The time [s].
        head: The contents of ``motion.json``, where that is missing.
    """
    try:
        _, width = _read_head(path, head)
        times = _scan(path, width, 1)[0][:, 0]
    except InputError:
        return 0
    return int(np.sum(times < before))


def _scan(path: Path, width: int, leading: int) -> tuple[Array, bool]:
    """The first numbers of the rows before one that is cut or wrong, and whether there is none.

    Wrong are values that are not finite and times that do not grow.

    Args:
        width: Numbers in a row.
        leading: How many of them are wanted.
    """
    found, last, step = [np.zeros((0, leading))], -np.inf, max(1, BLOCK // (8 * width))
    try:
        with open_regular(path) as file:
            while content := file.read(8 * width * step):
                block = np.frombuffer(content[: len(content) // (8 * width) * 8 * width])
                block = block.reshape(-1, width)
                grows = np.diff(block[:, 0], prepend=last) > 0.0
                good = np.isfinite(block).all(axis=1) & grows
                n = len(block) if good.all() else int(np.argmin(good))
                found.append(block[:n, :leading].copy())
                if n < len(block) or len(content) % (8 * width):
                    return np.concatenate(found), False
                last = block[-1, 0]
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    return np.concatenate(found), True


def describe_rows(rigid: Sequence[str], bodies: Sequence[MovedBody]) -> dict[str, Any]:
    """Names and sizes of what is in a row."""
    return {
        "version": VERSION,
        "byte_order": sys.byteorder,
        "rigid_bodies": list(rigid),
        "bodies": [vars(body) for body in bodies],
    }


def _head_of(path: Path) -> Path:
    """The file that says what the rows mean."""
    return path.with_suffix(".json")


def _read_head(path: Path, head: dict[str, Any] | None = None) -> tuple[dict[str, Any], int]:
    """Names and sizes of what is in a row, and the numbers in one.

    Args:
        head: The contents of ``motion.json``, where that is missing.
    """
    if path.is_dir():
        raise InputError(f"{str(path)!r} is a folder, name the motion.bin in it")
    try:
        if head is None or _head_of(path).exists():
            with open_regular(_head_of(path)) as file:
                head = json.loads(file.read())
        bodies = [MovedBody(**body) for body in head["bodies"]]
        if min([1, *(b.copies for b in bodies), *(b.vectors for b in bodies)]) < 1:
            raise ValueError
        if head != describe_rows(head["rigid_bodies"], bodies):
            raise ValueError
    except OSError as error:
        raise InputError(f"cannot read {str(_head_of(path))!r}: {error.strerror}") from None
    except InputError:
        raise
    except (ValueError, TypeError, KeyError):
        raise InputError(
            f"{str(path)!r} is not the motion of a run, or from another machine"
        ) from None
    return head, 1 + 24 * len(head["rigid_bodies"]) + 2 * sum(body.width for body in bodies)
