"""Files of field series, whatever their format: ``.xdmf`` or ``.vtkhdf``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.grid_series import GridSeries
from turbine_fenicsx.records.stored_grids import read_grids
from turbine_fenicsx.records.vtkhdf import VtkHdfSeries
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile
from turbine_fenicsx.records.xdmf import XdmfSeries

VTKHDF = ".vtkhdf"
"""Ending of the files of one format; all others are XDMF."""


def open_series(comm: MPI.Intracomm, path: str | os.PathLike[str], **given: Any) -> GridSeries:
    """A series in the format that the file's name says, see `GridSeries`. Collective."""
    kind = VtkHdfSeries if Path(path).suffix == VTKHDF else XdmfSeries
    return kind(comm, path, **given)


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
