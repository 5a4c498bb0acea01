"""Where the numbers of a field series are in a VTKHDF file.

The file holds an unstructured grid of one part (VTKHDF 2.0, "temporal"). Its cells and the fields
that do not change are there once, those that change once for each step; the group ``Steps`` says
where each step begins. All are plain arrays, one block each, with room for more steps than are
written. ``NSteps`` says how many count, and VTK's reader needs as many times as that. So a file is
whole whenever the program ends: the numbers of a step come first, then two small writes count it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError

GROUPS = {"Node": "PointData", "Cell": "CellData"}
"""Groups of fields by where they are."""

STEPS = "VTKHDF/Steps"

TOGETHER = 2**24
"""Bytes that are copied together."""


def import_h5py() -> Any:
    """The library.

    Raises:
        InputError: if it is missing.
    """
    try:
        import h5py
        from h5py import File  # noqa: F401  (Debian's python3-h5py-serial alone is an empty package)
    except (ImportError, ValueError) as error:  # beside another HDF5 it fails in its own ways
        raise InputError(
            "VTKHDF files need h5py: apt install python3-h5py for Debian's DOLFINx, pip install "
            f"h5py for others ({error})"
        ) from None
    return h5py


def open_file(path: Path, mode: str) -> Any:
    """A file, without a lock: ParaView may look at it during a run."""
    return import_h5py().File(path, mode, locking=False)


def need_h5py() -> None:
    """Raise an InputError if the library is missing."""
    import_h5py()


@dataclass(frozen=True)
class Block:
    """An array of a file.

    Args:
        name: Its path in the file.
        rows: Number of rows, of a step if it has some for each.
        width: Shape of a row, () or (3,).
        dtype: Type of the numbers, as of `numpy.dtype.str`.
        moves: Whether each step has its rows.
    """

    name: str
    rows: int
    width: tuple[int, ...]
    dtype: str
    moves: bool

    @property
    def row_size(self) -> int:
        """Size of a row [bytes]."""
        return int(np.dtype(self.dtype).itemsize * np.prod(self.width, dtype=int))


@dataclass(frozen=True)
class Layout:
    """The arrays of a file.

    Args:
        points: Number of points.
        cells: Number of cells.
        vertices: Number of vertices of all cells together.
        fields: Kind, name, shape of a row, type of the numbers, and whether each step has them.
    """

    points: int
    cells: int
    vertices: int
    fields: tuple[tuple[str, str, tuple[int, ...], str, bool], ...]

    def list_blocks(self) -> list[Block]:
        """The arrays: coordinates, cells, fields."""
        found = [
            Block(name_field("Node", ""), self.points, (3,), "<f8", True),
            Block("VTKHDF/Connectivity", self.vertices, (), "<i8", False),
            Block("VTKHDF/Offsets", self.cells + 1, (), "<i8", False),
            Block("VTKHDF/Types", self.cells, (), "|u1", False),
        ]
        for kind, name, width, dtype, moves in self.fields:
            rows = self.points if kind == "Node" else self.cells
            found.append(Block(name_field(kind, name), rows, width, dtype, moves))
        return found


def name_field(kind: str, name: str) -> str:
    """Path of a field in the file; that of the coordinates without a name."""
    return f"VTKHDF/{GROUPS[kind]}/{name}" if name else "VTKHDF/Points"


def make_file(
    path: Path, layout: Layout, room: int, information: Mapping[str, str], times: Sequence[float]
) -> None:
    """Make a file whose blocks have no numbers yet.

    Args:
        room: Number of steps that it has room for.
        information: Texts about the series by name.
        times: Times of its first steps, one or more [s].
    """
    with open_file(path, "w") as file:
        for name, text in information.items():
            file.attrs[name] = text
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        for name, number in (
            ("NumberOfPoints", layout.points),
            ("NumberOfCells", layout.cells),
            ("NumberOfConnectivityIds", layout.vertices),
        ):
            root[name] = np.array([number], dtype=np.int64)
        for group in GROUPS.values():
            root.create_group(group)
        for block in layout.list_blocks():
            rows = block.rows * (room if block.moves else 1)
            _allocate(file, block.name, (rows, *block.width), block.dtype)
        _make_steps(root.create_group("Steps"), layout, room, times)


def _allocate(file: Any, name: str, shape: tuple[int, ...], dtype: str) -> None:
    """Make an array that takes its place in the file now, and whose numbers come later."""
    h5py = import_h5py()
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    creation.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape)
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(np.dtype(dtype)), space, creation)


def _make_steps(group: Any, layout: Layout, room: int, times: Sequence[float]) -> None:
    """Where each step begins in the blocks."""
    group.attrs["NSteps"] = np.int64(len(times))
    still, counts = np.zeros(room, dtype=np.int64), np.arange(room, dtype=np.int64)
    group.create_dataset("Values", data=np.array(times), maxshape=(room,), chunks=(room,))
    group["NumberOfParts"], group["PartOffsets"] = np.ones(room, dtype=np.int64), still
    group["PointOffsets"] = counts * layout.points
    group["CellOffsets"], group["ConnectivityIdOffsets"] = still[:, None], still[:, None]
    for kind, rows in (("Node", layout.points), ("Cell", layout.cells)):
        offsets = group.create_group(f"{GROUPS[kind]}Offsets")
        for mine, name, _, _, moves in layout.fields:
            if mine == kind:
                offsets[name] = counts * rows if moves else still


def locate(path: Path, layout: Layout) -> tuple[int, dict[str, int]]:
    """Room of a file for steps, and where its blocks begin [bytes].

    Raises:
        ModelError: for a file of another layout.
    """
    places = {}
    with open_file(path, "r") as file:
        (room,) = file[f"{STEPS}/Values"].maxshape
        for block in layout.list_blocks():
            shape = (block.rows * (room if block.moves else 1), *block.width)
            found = file.get(block.name)
            if found is None or found.shape != shape or found.dtype.str != block.dtype:
                raise ModelError(f"{str(path)!r} has not the field {block.name!r} of this series")
            if block.rows:
                places[block.name] = found.id.get_offset()
    return room, places


def copy_steps(old: Path, new: Path, layout: Layout, room: int, steps: int) -> None:
    """Copy the first steps of a file to a new one with another room."""
    with open_file(old, "r") as source:
        times = source[f"{STEPS}/Values"][:steps]
        make_file(new, layout, room, dict(source.attrs), times)
        with open_file(new, "r+") as target:
            for block in layout.list_blocks():
                end = block.rows * (steps if block.moves else 1)
                part = max(1, TOGETHER // block.row_size)
                for first in range(0, end, part):
                    rows = slice(first, min(first + part, end))
                    target[block.name][rows] = source[block.name][rows]


def add_time(path: Path, step: int, time: float) -> None:
    """Set the time [s] of a step, which is then the last one of the file."""
    with open_file(path, "r+") as file:
        group = file[STEPS]
        if step + 1 < len(group["Values"]):  # there must never be more of them than NSteps
            group["Values"].resize((step + 1,))
            file.flush()
        group.attrs.modify("NSteps", np.int64(step + 1))
        file.flush()
        group["Values"].resize((step + 1,))
        group["Values"][step] = time
