"""A series of fields that a run writes at equal distances of time, and that survives a restart."""

from __future__ import annotations

import os
from abc import abstractmethod
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records.stored_grids import read_grids
from turbine_fenicsx.records.xdmf import XdmfSeries
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State

SHORTEST = 1e-9
"""Outputs at shorter distances [s] are those of all steps, and times divided by it are finite."""


class FieldSeries:
    """Base of observers that write XDMF files at set times; subclasses choose the fields.

    Args:
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].

    Attributes:
        name: Name of the XDMF file, under which checkpoints know it.
    """

    def __init__(self, path: str | os.PathLike[str], every: float, end: float) -> None:
        self._every, self._end = max(every, SHORTEST), end
        self._path, self.name = Path(path), Path(path).name
        self._series: XdmfSeries | None = None
        self._last: float | None = None
        self._next = 0.0

    @abstractmethod
    def _open(self, path: Path, append: float | None) -> XdmfSeries:
        """Open the series, with the times before one [s] on restart. Collective."""

    @abstractmethod
    def _write(self, series: XdmfSeries, state: State) -> None:
        """Write the fields of a state. Collective."""

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Open the files, which keep their times before the first state on restart."""
        time, every = snapshot.state.time, self._every
        self._series = self._open(self._path, append=time if resumed else None)
        self._last = last = self._series.last_kept
        self._next = np.ceil(time / every - 1e-9) * every
        if last is not None:
            self._next = (np.floor(last / every + 1e-9) + 1.0) * every
        self.observe(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Write if it is time to."""
        t = snapshot.state.time
        slack = 1e-9 * self._every
        if t < min(self._next, self._end) - slack:
            return
        self._next = (np.floor(t / self._every + 1e-9) + 1.0) * self._every
        assert self._series is not None
        self._last = t
        self._write(self._series, snapshot.state)

    def save(self) -> RestartData:
        """Bring the times to the disk; their number and the last one. Collective."""
        assert self._series is not None
        return RestartData({"times": self._series.sync(), "last_time": self._last})

    def restore(self, data: RestartData) -> None:
        """The files themselves have all that is needed."""

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Times that the files lack before a checkpoint; that of the checkpoint is rewritten."""
        first, n = time - 1e-9 * max(1.0, abs(time)), data.numbers
        there = sum(grid.time < first for grid in read_grids(self._path))
        needed = n["times"] - (n["times"] > 0 and n["last_time"] >= first)
        return describe_shortfall(self.name, there, needed, "times", time)

    def finish(self) -> None:
        """The files are closed already: they are open inside the calls only."""
