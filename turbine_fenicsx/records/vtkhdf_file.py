"""A VTKHDF file of a field series, read back as arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import open_regular
from turbine_fenicsx.records.vtkhdf_layout import GROUPS, STEPS, open_file


@dataclass(frozen=True, eq=False)
class FieldStep:
    """The fields of one time.

    Args:
        time: The time [s].
        points: Coordinates, shape (n, 3) [m].
        point_data: Fields at the points by name, shapes (n,) or (n, 3).
        cell_data: Fields in the m cells by name, shapes (m,) or (m, 3).
    """

    time: float
    points: NDArray[np.float64]
    point_data: Mapping[str, NDArray[Any]]
    cell_data: Mapping[str, NDArray[Any]]


class VtkHdfFile:
    """A file that `turbine_fenicsx.records.vtkhdf` has written, as a context.

    Args:
        path: The file.

    Attributes:
        times: Times of the steps, shape (steps,) [s].
        information: Texts about the series by name.
        types: VTK's number of the kind of each cell, shape (m,).
        offsets: Where the vertices of each cell begin, and the last ones end, shape (m + 1,).
        connectivity: Points of the cells, one cell after another.

    Raises:
        InputError: for a file that cannot be read, or is none of these.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = Path(path)
        try:
            with open_regular(path):
                self._file = open_file(self._path, "r")
        except OSError as error:
            raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
        try:
            self._check()
        except InputError:
            self._file.close()
            raise
        except (KeyError, ValueError, TypeError, OSError, RuntimeError, AttributeError) as error:
            self._file.close()
            raise self._refuse(str(error)) from None

    def _refuse(self, reason: str) -> InputError:
        """An error of a file that cannot be read for a reason."""
        path = str(self._path)
        return InputError(f"{path!r} is not the field output of a run, or damaged ({reason})")

    def _check(self) -> None:
        """Look whether all arrays are there and fit together, before somebody depends on it."""
        file, steps = self._file, self._file[STEPS]
        self._size = os.path.getsize(self._path)
        if file["VTKHDF"].attrs["Type"] != b"UnstructuredGrid":
            raise self._refuse("no unstructured grid")
        self.information = {str(key): str(text) for key, text in file.attrs.items()}
        (n,), (m,), (k,) = (
            self._take(f"VTKHDF/NumberOf{name}").astype(int).tolist()
            for name in ("Points", "Cells", "ConnectivityIds")
        )
        count = min(int(steps.attrs["NSteps"]), len(steps["Values"]))
        if min(count, n, m, k) < 0 or len(steps["Values"]) > self._size:
            raise self._refuse("sizes cannot be")
        self.times: NDArray[np.float64] = np.asarray(steps["Values"][:count], dtype=np.float64)
        if not (np.isfinite(self.times).all() and (np.diff(self.times) > 0.0).all()):
            raise self._refuse("times do not rise")
        self.types, self.offsets, self.connectivity = (
            self._take(f"VTKHDF/{name}") for name in ("Types", "Offsets", "Connectivity")
        )
        ends = self.offsets
        if len(self.types) != m or len(ends) != m + 1 or len(self.connectivity) != k:
            raise self._refuse("cells are missing")
        if ends[0] != 0 or ends[-1] != k or (np.diff(ends) < 0).any():
            raise self._refuse("cells have no vertices")
        if k and not 0 <= self.connectivity.min() <= self.connectivity.max() < n:
            raise self._refuse("cells have points that are not there")
        self._rows = {"Points": (self._find("VTKHDF/Points"), n, self._starts("PointOffsets"))}
        for group, rows in zip(GROUPS.values(), (n, m), strict=True):
            for name in file[f"VTKHDF/{group}"]:
                array = self._find(f"VTKHDF/{group}/{name}")
                self._rows[f"{group}/{name}"] = array, rows, self._starts(f"{group}Offsets/{name}")
        for name, (array, rows, starts) in self._rows.items():
            if (starts < 0).any() or (starts + rows > len(array)).any():
                raise self._refuse(f"{name} is too short")

    def _starts(self, name: str) -> NDArray[np.int64]:
        """First row of each step."""
        found = np.asarray(self._take(f"{STEPS}/{name}"), dtype=np.int64).ravel()
        if len(found) < len(self.times):
            raise self._refuse(f"{name} is too short")
        return found[: len(self.times)]

    def _find(self, name: str) -> Any:
        """An array, all of whose numbers are in this file."""
        found = self._file[name]
        start = found.id.get_offset()
        if found.size and (start is None or start + found.size * found.dtype.itemsize > self._size):
            raise self._refuse(f"{name} has no numbers")
        if found.dtype.kind not in "iuf":
            raise self._refuse(f"{name} has no numbers")
        return found

    def _take(self, name: str) -> NDArray[Any]:
        """The numbers of an array."""
        return np.asarray(self._find(name)[()])

    def read(self, step: int) -> FieldStep:
        """The fields of one time.

        Args:
            step: Its number, from 0.
        """
        found: dict[str, NDArray[Any]] = {}
        for name, (array, rows, starts) in self._rows.items():
            first = int(starts[step])
            found[name] = array[first : first + rows]
        of_points, of_cells = (
            {name.partition("/")[2]: x for name, x in found.items() if name.startswith(f"{group}/")}
            for group in GROUPS.values()
        )
        return FieldStep(float(self.times[step]), found["Points"], of_points, of_cells)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> VtkHdfFile:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
