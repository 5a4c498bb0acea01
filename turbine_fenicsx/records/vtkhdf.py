"""Field output as one VTKHDF file, for ParaView and PyVista; written in parallel.

HDF5 makes room for the numbers on rank 0; all ranks write them there by MPI-IO. So any build of
h5py will do, and a step costs what writing its numbers does. See
`turbine_fenicsx.records.vtkhdf_layout`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.files import name_file_in_errors, sync_file, sync_folder
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together
from turbine_fenicsx.records.grid_series import FieldRows, GridSeries, Share
from turbine_fenicsx.records.number_files import write_at_all
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile
from turbine_fenicsx.records.vtkhdf_layout import (
    Layout,
    add_time,
    copy_steps,
    locate,
    make_file,
    name_field,
    need_h5py,
)

KINDS = {"line": 3, "triangle": 5, "quadrilateral": 9, "tetrahedron": 10, "hexahedron": 12}
"""VTK's numbers of the kinds of cells."""


class VtkHdfSeries(GridSeries):
    """Time series of fields in a VTKHDF file, which is there from the first time on.

    Raises:
        InputError: without h5py.
    """

    def _start(self, append: float | None) -> None:
        """Start or continue the series."""
        on_rank0(self._comm, need_h5py)
        self._times, self.last_kept = on_rank0(self._comm, lambda: self._open(append))
        self._layout: Layout | None = None
        self._places: dict[str, int] = {}

    def _open(self, append: float | None) -> tuple[int, float | None]:
        """Number of the times before ``append``, and the last of them; without, no file."""
        with name_file_in_errors("write", self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            if append is not None and self._path.exists():
                limit = append - 1e-9 * max(1.0, abs(append))
                try:
                    with VtkHdfFile(self._path) as file:
                        times = file.times[file.times < limit]
                except InputError:
                    times = np.zeros(0)
                if len(times):
                    self._call(add_time, self._path, len(times) - 1, times[-1])
                    return len(times), float(times[-1])
            self._path.unlink(missing_ok=True)
        return 0, None

    def _write(self, t: float, fields: Sequence[FieldRows]) -> None:
        """Write one time."""
        if self._layout is None:
            self._layout = self._make_layout(fields[1:])
            if not self._times:
                self._begin(self._layout, t, fields)
                return
            self._find_places(self._path, self._layout)
        if self._times == self._room:
            on_rank0(self._comm, partial(self._resize, self._layout, 2 * self._room))
            self._find_places(self._path, self._layout)
        self._write_rows(self._path, self._name_rows(fields), self._times)
        on_rank0(self._comm, partial(self._call, add_time, self._path, self._times, t))
        self._times += 1

    def _make_layout(self, fields: Sequence[FieldRows]) -> Layout:
        """The arrays of the file."""
        n_ids = self._comm.allreduce(sum(block.size for _, block in self._cells))
        known = [*((f, False) for f in self._static), *((f, True) for f in fields)]
        return Layout(
            self._shares["Node"].total,
            self._shares["Cell"].total,
            n_ids,
            tuple((f.kind, f.name, f.values.shape[1:], f.values.dtype.str, m) for f, m in known),
        )

    def _begin(self, layout: Layout, t: float, fields: Sequence[FieldRows]) -> None:
        """Make the file, with what does not change and the first time."""
        ids = Share.of(self._comm, sum(block.size for _, block in self._cells))
        cells = self._shares["Cell"]
        draft = self._path.with_name(self._path.name + ".part")
        make = partial(make_file, draft, layout, self._room, self._information, [t])
        on_rank0(self._comm, partial(self._call, make))
        self._find_places(draft, layout)
        kinds = [np.full(len(b), KINDS[kind], dtype=np.uint8) for kind, b in self._cells]
        widths = [np.full(len(b), b.shape[1], dtype=np.int64) for _, b in self._cells]
        ends = ids.first + np.cumsum(_join(widths, np.int64))
        last = self._comm.rank == self._comm.size - 1
        starts = np.append(ids.first, ends)[: None if last else -1]
        topology: list[tuple[str, Share, NDArray[Any]]] = [
            ("VTKHDF/Connectivity", ids, _join([b.ravel() for _, b in self._cells], np.int64)),
            ("VTKHDF/Types", cells, _join(kinds, np.uint8)),
            ("VTKHDF/Offsets", Share(len(starts), cells.first, cells.total + 1), starts),
        ]
        self._write_rows(draft, [*topology, *self._name_rows([*self._static, *fields])], 0)
        on_rank0(self._comm, partial(self._replace, draft))
        self._times = 1

    def _name_rows(self, fields: Sequence[FieldRows]) -> list[tuple[str, Share, NDArray[Any]]]:
        """Fields with their places in the file."""
        return [(name_field(kind, name), self._shares[kind], x) for kind, name, x in fields]

    def _write_rows(
        self, path: Path, arrays: Sequence[tuple[str, Share, NDArray[Any]]], step: int
    ) -> None:
        """Write arrays of this rank to their places; an error is raised on all ranks."""
        places, parts = [], []
        for name, share, values in arrays:
            if name in self._places:
                row = values.itemsize * int(np.prod(values.shape[1:], dtype=int))
                start = self._places[name] + step * share.total * row
                places.append((start, share.total * row))
                parts.append((start + share.first * row, np.ascontiguousarray(values)))
        on_rank0(self._comm, partial(_make_room, path, places))
        raise_together(self._comm, write_at_all(self._comm, path, parts))

    def _find_places(self, path: Path, layout: Layout) -> None:
        """Find where the arrays of the file begin."""
        self._room, self._places = on_rank0(self._comm, partial(self._call, locate, path, layout))

    def _resize(self, layout: Layout, room: int) -> None:
        """Give the file another room, on rank 0."""
        draft = self._path.with_name(self._path.name + ".part")
        self._call(copy_steps, self._path, draft, layout, room, self._times)
        self._replace(draft)

    def _replace(self, draft: Path) -> None:
        """Let a new file take the place of the old one."""
        sync_file(draft)
        with name_file_in_errors("write", self._path):
            os.replace(draft, self._path)
            sync_folder(self._path.parent)

    def _call(self, act: Any, *values: Any) -> Any:
        """Call a function of a file; errors of HDF5 become those of the file."""
        try:
            return act(*values)
        except (OSError, RuntimeError, KeyError) as error:
            raise FileError(f"cannot write {self._path}: {error}") from None

    def sync(self) -> int:
        """Wait until all times are on the disk; their number."""
        if self._times:
            on_rank0(self._comm, partial(sync_file, self._path))
        return self._times

    def finish(self) -> None:
        """Give back the room that is not used."""
        if self._layout is not None and self._times < self._room:
            on_rank0(self._comm, partial(self._resize, self._layout, self._times))


def _join(parts: Sequence[NDArray[Any]], kind: Any) -> NDArray[Any]:
    """Arrays one after another; there may be none."""
    return np.concatenate([np.zeros(0, dtype=kind), *parts])


def _make_room(path: Path, places: Sequence[tuple[int, int]]) -> None:
    """Let the disk reserve some bytes, so that a full one is noticed.

    Args:
        places: Where they begin, and how many they are.
    """
    with name_file_in_errors("write", path), path.open("r+b") as file:
        for start, size in places:
            if size:
                os.posix_fallocate(file.fileno(), start, size)
