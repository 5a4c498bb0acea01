"""A series of fields that a run writes at equal distances of time, and that survives a restart."""

from __future__ import annotations

import os
from abc import abstractmethod
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records.field_files import read_whole_times
from turbine_fenicsx.records.grid_series import ROOM, GridSeries
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State

SHORTEST = 1e-9
"""Outputs at shorter distances [s] are those of all steps, and times divided by it are finite."""

MOST = 100_000
"""Times that a file has room for at first."""


class FieldSeries:
    """Base of observers that write fields at set times; subclasses choose them.

    Args:
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].

    Attributes:
        name: Name of the file, under which checkpoints know it.
    """

    def __init__(self, path: str | os.PathLike[str], every: float, end: float) -> None:
        self._every, self._end = max(every, SHORTEST), end
        self._path, self.name = Path(path), Path(path).name
        self._series: GridSeries | None = None
        self._last: float | None = None
        self._next = 0.0

    @abstractmethod
    def open(self, path: Path, append: float | None, room: int) -> GridSeries:
        """Open a series. Collective.

        Args:
            path: The file.
            append: Time before which an existing series is kept [s]; None for a new one.
            room: Number of times that it has room for.
        """

    @abstractmethod
    def write(self, series: GridSeries, state: State) -> None:
        """Write the fields of a state. Collective."""

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Open the files, which keep their times before the first state on restart."""
        time, every = snapshot.state.time, self._every
        count = np.ceil((self._end - time) / every - 1e-9) + 1.0 if every > SHORTEST else ROOM
        self._series = self.open(self._path, time if resumed else None, int(min(count, MOST)))
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
        self.write(self._series, snapshot.state)

    def save(self) -> RestartData:
        """Bring the times to the disk; their number and the last one. Collective."""
        assert self._series is not None
        return RestartData({"times": self._series.sync(), "last_time": self._last})

    def restore(self, data: RestartData) -> None:
        """The files themselves have all that is needed."""

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Times that the files lack before a checkpoint; that of the checkpoint is rewritten."""
        first, n = time - 1e-9 * max(1.0, abs(time)), data.numbers
        there = int(np.sum(read_whole_times(self._path) < first))
        needed = n["times"] - (n["times"] > 0 and n["last_time"] >= first)
        return describe_shortfall(self.name, there, needed, "times", time)

    def finish(self) -> None:
        """Give back room that was not needed. Collective."""
        if self._series is not None:
            self._series.finish()
