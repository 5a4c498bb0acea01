"""Files of field series, whatever their format: ``.xdmf`` or ``.vtkhdf``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.grid_series import GridSeries
from turbine_fenicsx.records.stored_grids import read_grids
from turbine_fenicsx.records.vtkhdf import ROOM, VtkHdfSeries
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile
from turbine_fenicsx.records.xdmf import XdmfSeries

VTKHDF = ".vtkhdf"
"""Ending of the files of one format; all others are XDMF."""


def open_series(
    comm: MPI.Intracomm,
    path: str | os.PathLike[str],
    cells: Sequence[tuple[str, NDArray[Any]]],
    n_points: int,
    *,
    room: int = ROOM,
    **more: Any,
) -> GridSeries:
    """A series in the format that its file's name says. Collective.

    Args:
        cells: As of either, like the number of points.
        room: As of `VtkHdfSeries`, which it is for.
        **more: More arguments of either.
    """
    if Path(path).suffix == VTKHDF:
        return VtkHdfSeries(comm, path, cells, n_points, room=room, **more)
    return XdmfSeries(comm, path, cells, n_points, **more)


def read_whole_times(path: Path) -> NDArray[np.float64]:
    """Times [s] of a series that a run may continue; of none if there is no such file."""
    if path.suffix != VTKHDF:
        return np.array([grid.time for grid in read_grids(path)])
    if not path.exists():
        return np.zeros(0)
    try:
        with VtkHdfFile(path) as file:
            return file.times
    except InputError:
        return np.zeros(0)
