"""``history.outb``: OpenFAST's binary output, a seventh as large as text.

The times are whole numbers of 32 bits, the values of each channel whole numbers of 16 bits over its
range, as OpenFAST itself writes them (format 1). Numbers without loss stand in ``history.out``.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.types import Array

_WITH_TIME = 1
"""Number of the format."""

_NAME = 10
"""Characters of a name or a unit; longer ones are cut off."""


def write_openfast_binary(text: Path) -> None:
    """Write the numbers of a ``history.out`` beside it, as ``history.outb``.

    Args:
        text: The file of text; without any row there is nothing to write.
    """
    lines = text.read_text(encoding="ascii").splitlines()
    title, names, units, rows = lines[4], lines[6].split(), lines[7].split(), lines[8:]
    if not rows:
        return
    table = np.array([line.split() for line in rows], dtype=float)
    (scale,), (offset,) = _find_scale(table[:, :1], 31)
    scales, offsets = (x.astype("<f4") for x in _find_scale(table[:, 1:], 15))
    described = title.strip().encode()
    time = np.rint(table[:, 0] * scale + offset).astype("<i4")
    values = np.rint(table[:, 1:] * scales + offsets).clip(-(2.0**15), 2.0**15 - 1.0)
    parts = (
        struct.pack("<hiidd", _WITH_TIME, len(names) - 1, len(table), scale, offset),
        *(scales.tobytes(), offsets.tobytes()),
        struct.pack("<i", len(described)) + described,
        *(word.encode()[:_NAME].ljust(_NAME) for word in (*names, *units)),
        *(time.tobytes(), values.astype("<i2").tobytes()),
    )
    replace_file(text.with_suffix(".outb"), b"".join(parts))


def _find_scale(values: Array, bits: int) -> tuple[Array, Array]:
    """Scale and offset of x = (whole number - offset)/scale for each column, shape (n,)."""
    low, high = values.min(axis=0), values.max(axis=0)
    scale = (2.0 ** (bits + 1) - 1.0) / np.where(high > low, high - low, 1.0)
    return scale, -(2.0**bits) - scale * low
