"""Input and commands of a controller: a row of numbers for each call, packed."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Iterator, Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array

BLOCK = 10_000
"""Calls that are packed together."""


class CallHistory:
    """Rows of calls. Full blocks are packed, a tenth of a kilobyte for each call.

    Attributes:
        count: Number of rows.
    """

    def __init__(self) -> None:
        self.count = 0
        self._packed = bytearray()
        self._rest = array("d")
        self._width = 0

    def append(self, row: Sequence[float]) -> None:
        """Append a row; all have the same length."""
        self.count += 1
        self._width = len(row)
        self._rest.extend(row)
        if len(self._rest) >= BLOCK * self._width:
            self._packed += _pack(self._rest, self._width)
            self._rest = array("d")

    def pack(self) -> bytes:
        """All rows."""
        return bytes(self._packed) + (_pack(self._rest, self._width) if self._rest else b"")


def _pack(rows: array[float], width: int) -> bytes:
    """Pack rows by columns, as whole columns may hold one number."""
    return zlib.compress(np.array(rows).reshape(-1, width).T.tobytes(), level=1)


def unpack(packed: bytes, width: int) -> Iterator[Array]:
    """The rows of histories that were packed, one after another, each of shape (width,)."""
    while packed:
        stream = zlib.decompressobj()
        columns = np.frombuffer(stream.decompress(packed)).reshape(width or 1, -1)
        yield from columns.T
        packed = stream.unused_data
