"""The work of the air on each blade.

Forces F and moments M act on the sections of a blade, which move with v and turn with omega in the
middle of a step. Their work dt sum (F.v + M.omega) is that blade's share of the work of the wind to
round-off: loads go to nodes and directors by the transpose of how these move.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from turbine_fenicsx.forces.line_source import StepLoads
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.snapshot import Snapshot


class BladeWorks:
    """Adds up the works of a run, step after step, and survives a restart.

    Args:
        blades: Number of blades, each with equally many stations.
        find_loads: Loads in the step that led to a state; called on all ranks.

    Attributes:
        name: Under which checkpoints know it.
        works: Work on each blade since the start, shape (blades,) [J].
    """

    name = "works on blades"

    def __init__(self, blades: int, find_loads: Callable[[Snapshot], StepLoads]) -> None:
        self._find_loads = find_loads
        self.works: Array = np.zeros(blades)

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """No step is done yet."""

    def observe(self, snapshot: Snapshot) -> None:
        """Add the works of a step."""
        motion, F, M, times = self._find_loads(snapshot)
        power = np.sum(F * motion.velocity + M * motion.angular_velocity, axis=1)
        self.works += times.dt * power.reshape(len(self.works), -1).sum(axis=1)

    def finish(self) -> None:
        """Nothing has to be closed."""

    def save(self) -> RestartData:
        """The works so far."""
        return RestartData({"works": self.works.tolist()})

    def restore(self, data: RestartData) -> None:
        """Restore works."""
        self.works = np.array(data.numbers["works"], dtype=float)
