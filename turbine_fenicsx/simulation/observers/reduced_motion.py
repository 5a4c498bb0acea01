"""The motion of reduced bodies at equal distances of time, from which all else can be recovered."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.motion_file import (
    SAME_TIME,
    MotionFile,
    MovedBody,
    count_rows,
    describe_rows,
)
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.reduced_model import ReducedModel
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


def describe_body(model: ReducedModel) -> MovedBody:
    """A reduced body as the files describe it."""
    return MovedBody(model.body.name, model.copies, len(model.mass), model.meaning)


class ReducedMotion:
    """Writes ``motion.bin`` and ``motion.json``, see `turbine_fenicsx.records.motion_file`.

    Args:
        every: Simulated time between two rows [s], positive; the end is always written.
        end: End time [s].

    Attributes:
        name: Name of the file, under which checkpoints know it.
    """

    def __init__(
        self, system: MultibodySystem, path: str | os.PathLike[str], every: float, end: float
    ) -> None:
        self._system, self._every, self._end = system, every, end
        self._path, self.name = Path(path), Path(path).name
        models = enumerate(system.flexible_models)
        self._models = [(k, model) for k, model in models if isinstance(model, ReducedModel)]
        if not self._models:
            raise ModelError("the motion of reduced bodies needs a system with such bodies")
        self._bodies = [describe_body(model) for _, model in self._models]
        self._rigid = [body.name for body in self._system.rigid_bodies]
        self._file: MotionFile | None = None
        self._next, self._last = 0.0, -np.inf

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Begin the files; on restart they keep their rows before the first state."""
        time = snapshot.state.time
        keep = time if resumed else None
        self._file = MotionFile(self._system.comm, self._path, self._rigid, self._bodies, keep)
        self._next = np.ceil(time / self._every - 1e-9) * self._every
        self.observe(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Write a row if it is time to."""
        t = snapshot.state.time
        if t < min(self._next, self._end) - 1e-9 * self._every:
            return
        self._next = (np.floor(t / self._every + 1e-9) + 1.0) * self._every
        self._last = t
        assert self._file is not None
        self._file.append(self._make_row(snapshot.state))

    def _make_row(self, state: State) -> Array:
        """The numbers of a state; those of vectors on rank 0 alone."""
        parts = [np.array([state.time]), state.q, state.q_dot]
        for k, model in self._models:
            parts += [model.vectors(state.u[k].array_r).ravel(), state.v[k].array_r]
        return np.concatenate(parts)

    def save(self) -> RestartData:
        """Bring the rows to the disk; their number and the last time. Collective."""
        assert self._file is not None
        return RestartData({"rows": self._file.sync(), "last_time": self._last})

    def restore(self, data: RestartData) -> None:
        """The files themselves have all that is needed."""

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Rows that the file lacks before a checkpoint; that of the checkpoint is rewritten."""
        first, n = time - SAME_TIME * max(1.0, abs(time)), data.numbers
        needed = n["rows"] - (n["rows"] > 0 and n["last_time"] >= first)
        there = count_rows(self._path, first, describe_rows(self._rigid, self._bodies))
        return describe_shortfall(self.name, there, needed, "rows", time)

    def finish(self) -> None:
        """The files are closed already: they are open inside the calls only."""
