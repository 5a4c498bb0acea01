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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.files import name_file_in_errors, replace_file, sync_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.grid_series import FieldRows, GridSeries, Share
from turbine_fenicsx.records.number_files import NumberFiles, Rows
from turbine_fenicsx.records.stored_grids import read_grids

KINDS: dict[str, tuple[int, ...]] = {
    "line": (2, 2),
    "triangle": (4,),
    "quadrilateral": (5,),
    "tetrahedron": (6,),
    "hexahedron": (9,),
}
"""Numbers before the vertices of a cell: that of its kind, for lines also that of vertices."""


def _make_topology(cells: Sequence[tuple[str, NDArray[Any]]]) -> NDArray[np.int32]:
    """Cells as XDMF wants a mixed topology: number of the kind, its vertices, and so on."""
    parts = [np.empty(0, dtype=np.int32)]
    for kind, vertices in cells:
        head = np.broadcast_to(np.array(KINDS[kind]), (len(vertices), len(KINDS[kind])))
        parts.append(np.hstack([head, vertices]).astype(np.int32).ravel())
    return np.concatenate(parts)


_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
_SERIES = '<Grid Name="series" GridType="Collection" CollectionType="Temporal">\n'
_TAIL = "</Grid>\n</Domain>\n</Xdmf>\n"


class XdmfSeries(GridSeries):
    """Time series of fields in XDMF files."""

    def _start(self, append: float | None) -> None:
        """Start or continue the series, and write what does not change in time."""
        self._head = _format_head(self._information)
        self._tail_at: int | None = None
        topology = _make_topology(self._cells)
        self._shares["Topology"] = Share.of(self._comm, len(topology))
        self._times, self.last_kept, place = on_rank0(self._comm, lambda: self._open(append))
        self._numbers = NumberFiles(self._comm, self._path, place)
        items = self._write_arrays([FieldRows("Topology", "", topology), *self._static])
        self._topology = (
            f'<Topology TopologyType="Mixed" NumberOfElements="{self._shares["Cell"].total}">'
            f"{items[0]}</Topology>\n"
        )
        self._unchanged = _format_attributes(self._static, items[1:])

    def _write(self, t: float, fields: Sequence[FieldRows]) -> None:
        """Write one time."""
        items = self._write_arrays(fields)
        geometry = items[0].replace(">", f"><!-- t = {t!r} s -->", 1)
        grid = (
            f'<Grid Name="mesh" GridType="Uniform"><Time Value="{t!r}"/>\n'
            f'{self._topology}<Geometry GeometryType="XYZ">{geometry}</Geometry>\n'
            f"{_format_attributes(fields[1:], items[1:])}{self._unchanged}</Grid>\n"
        )
        on_rank0(self._comm, lambda: self._extend_xml(grid))
        self._times += 1

    def sync(self) -> int:
        """Wait until all times are on the disk; their number."""
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

    def _write_arrays(self, arrays: Sequence[FieldRows]) -> list[str]:
        """Write arrays of this rank, return their ``DataItem`` elements."""
        return self._numbers.append([Rows(f.values, *self._shares[f.kind][1:]) for f in arrays])

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


def _format_attributes(fields: Sequence[FieldRows], items: Sequence[str]) -> str:
    """``Attribute`` elements of fields and their ``DataItem`` elements."""
    return "".join(
        f'<Attribute Name="{escape(name)}" Center="{kind}" '
        f'AttributeType="{"Scalar" if values.ndim == 1 else "Vector"}">{item}</Attribute>\n'
        for (kind, name, values), item in zip(fields, items, strict=True)
    )
