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
class Motion:
    """The motion of a run.

    Args:
        times: Shape (rows,) [s].
        q: Coordinates of the rigid bodies, shape (rows, 12 bodies).
        q_dot: Their rates.
        rigid: Names of the rigid bodies.
        bodies: The reduced bodies.
        vectors: Vectors z of each, shape (rows, copies, n, 3).
        velocities: Their velocities.
    """

    times: Array
    q: Array
    q_dot: Array
    rigid: tuple[str, ...]
    bodies: tuple[MovedBody, ...]
    vectors: tuple[Array, ...]
    velocities: tuple[Array, ...]


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
            head, values = _read_rows(self._path, self._head)
            if head != self._head:
                raise InputError(f"{str(self._path)!r} holds the motion of other bodies")
            good = values[: _count_good(values)]
            rows = int(np.sum(good[:, 0] < keep - SAME_TIME * max(1.0, abs(keep))))
            with name_file_in_errors("write", self._path):
                os.truncate(self._path, rows * 8 * values.shape[1])
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
    head, rows = _read_rows(Path(path))
    good = _count_good(rows)
    if good < len(rows) or os.path.getsize(path) % rows.strides[0]:
        warnings.warn(
            f"{os.fspath(path)} is whole up to row {good}; those from there on are left out, which "
            "are cut, hold no numbers, or have times that do not grow",
            ModelWarning,
            stacklevel=2,
        )
        rows = rows[:good]
    rigid, bodies = tuple(head["rigid_bodies"]), tuple(MovedBody(**b) for b in head["bodies"])
    widths = [1, *[12 * len(rigid)] * 2, *(b.width for b in bodies for _ in range(2))]
    times, q, q_dot, *parts = np.split(rows, np.cumsum(widths)[:-1], axis=1)
    shaped = [
        part.reshape(len(rows), b.copies, b.vectors, 3)
        for part, b in zip(parts, (b for b in bodies for _ in range(2)), strict=True)
    ]
    return Motion(times[:, 0], q, q_dot, rigid, bodies, tuple(shaped[::2]), tuple(shaped[1::2]))


def count_rows(path: Path, before: float, head: dict[str, Any]) -> int:
    """Number of good rows before a time in files that may be missing.

    Args:
        before: The time [s].
        head: The contents of ``motion.json``, where that is missing.
    """
    try:
        _, rows = _read_rows(path, head)
    except InputError:
        return 0
    return int(np.sum(rows[: _count_good(rows), 0] < before))


def _count_good(rows: Array) -> int:
    """Number of rows before the first with a value that is not finite or a time that falls.

    Args:
        rows: Shape (rows, width).
    """
    good = np.isfinite(rows).all(axis=1) & np.append(True, np.diff(rows[:, 0]) > 0.0)[: len(rows)]
    return len(rows) if good.all() else int(np.argmin(good))


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


def _read_rows(path: Path, head: dict[str, Any] | None = None) -> tuple[dict[str, Any], Array]:
    """Names and sizes of what is in a row, and the rows that are whole, shape (rows, width).

    Args:
        head: The contents of ``motion.json``, where that is missing.
    """
    name, opened = str(path), path
    try:
        if path.is_dir():
            raise InputError(f"{name!r} is a folder, name the motion.bin in it")
        if head is None or _head_of(path).exists():
            opened = _head_of(path)
            with open_regular(opened) as file:
                head = json.loads(file.read())
        bodies = [MovedBody(**body) for body in head["bodies"]]
        if min([1, *(b.copies for b in bodies), *(b.vectors for b in bodies)]) < 1:
            raise ValueError
        if head != describe_rows(head["rigid_bodies"], bodies):
            raise ValueError
        width = 1 + 24 * len(head["rigid_bodies"]) + 2 * sum(body.width for body in bodies)
        opened = path
        with open_regular(opened) as file:
            content = file.read()
    except OSError as error:
        raise InputError(f"cannot read {str(opened)!r}: {error.strerror}") from None
    except InputError:
        raise
    except (ValueError, TypeError, KeyError):
        raise InputError(f"{name!r} is not the motion of a run, or from another machine") from None
    whole = len(content) // (8 * width)
    return head, np.frombuffer(content[: 8 * width * whole]).reshape(whole, width)
