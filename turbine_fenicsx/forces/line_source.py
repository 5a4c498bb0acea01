"""A source of loads on sections in the course of a run: it moves on once per accepted step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.load_slopes import find_slopes
from turbine_fenicsx.forces.load_states import StateLoad, WithoutStates, find_states
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

SAME_TIME = 1e-6
"""Maximum gap between the end of a step and the start of the next one, relative to its length."""


class StepLoads(NamedTuple):
    """Loads on sections in a step.

    Attributes:
        motion: How the sections move in its middle.
        force: Forces on them, shape (n, 3) [N].
        moment: Moments about their centres, shape (n, 3) [N m].
    """

    motion: SectionMotion
    force: Array
    moment: Array
    times: StepTimes


class LineSource:
    """A source whose wakes and the like move on when the step after an accepted one begins.

    They also move on when data are saved. A step that is repeated leaves no trace.

    Args:
        stations: Number of stations.

    Attributes:
        last: Loads in the last step that was done; None before the first.
    """

    def __init__(self, name: str, stations: int, source: LineLoad) -> None:
        self.name, self._shape, self._source = name, (stations, 3), source
        self._waits = False
        self.last: StepLoads | None = None

    def start_step(self, times: StepTimes) -> None:
        """A step begins: the one before was accepted if this one follows it."""
        start = times.end - times.dt if np.isfinite(times.dt) else times.end
        if self._waits and self.last is not None:
            before = self.last.times
            if abs(start - before.end) <= SAME_TIME * before.dt:
                self._accept()
        self._waits = False
        self._source.start_step(times)

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """Forces and moments on the sections."""
        F, M = self._source.loads(motion, time)
        for what, values in (("forces", F), ("moments", M)):
            if np.shape(values) != self._shape:
                raise ModelError(
                    f"{what} of {self.name!r} must have the shape {self._shape}, got "
                    f"{np.shape(values)}"
                )
        return np.asarray(F), np.asarray(M)

    def slopes(self, motion: SectionMotion, times: StepTimes) -> Array:
        """Derivatives of the loads by increments of a step, shape (n, 6, 6)."""
        return find_slopes(self._source, motion, times)

    @property
    def states(self) -> StateLoad | WithoutStates:
        """The source as loads that follow from states."""
        return find_states(self._source)

    def read_states(self) -> Array | None:
        """States after the last step, see `StateLoad.read_states`."""
        if self._waits:
            self._accept()
        return self.states.read_states()

    def tell(self, times: StepTimes) -> None:
        """Announce the motion for which the source is called outside of the steps of a run."""
        self._source.start_step(times)

    def finish(self, loads: StepLoads) -> None:
        """A step is done, if none repeats it."""
        self.last, self._waits = loads, True

    def save(self) -> RestartData:
        """Data of the source after the last step."""
        if self._waits:
            self._accept()
        return self._source.save()

    def restore(self, data: RestartData) -> None:
        """Resume where the data were saved; start from scratch without any."""
        self._waits, self.last = False, None
        self._source.restore(data)

    def _accept(self) -> None:
        """Let the source move on over the step that was done."""
        assert self.last is not None
        self._source.accept(self.last.motion, self.last.times)
        self._waits = False
