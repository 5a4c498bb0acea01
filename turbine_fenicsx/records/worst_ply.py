"""The largest failure index of all plies in a run: how large, where, when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import TimeSeries


@dataclass(frozen=True)
class WorstPly:
    """Where plies come nearest to failure.

    Args:
        index: The failure index; a ply fails at 1 [-].
        place: Distance from the root [m].
        time: When [s].
    """

    index: float
    criterion: str
    panel: str
    place: float
    time: float

    @property
    def warning(self) -> str:
        """A sentence if plies fail; else nothing."""
        if self.index <= 1.0:
            return ""
        return (
            f"plies fail: the largest index of {self.criterion} is {self.index:.3g}, in "
            f"{self.panel} {self.place:.4g} m from the root at t = {self.time:.4g} s; 1 is failure"
        )


def find_worst_ply(history: TimeSeries) -> WorstPly | None:
    """The largest failure index of a run; None if its history has none."""
    found = []
    for criterion in CRITERIA:
        places = history.of(names.PLY_INDEX_AT, criterion=criterion)
        for panel, indices in history.of(names.PLY_INDEX, criterion=criterion).items():
            if panel in places and np.isfinite(indices).any():
                k = int(np.nanargmax(indices))
                place, time = places[panel][k], history[names.TIME][k]
                index = float(indices[k])
                found.append(WorstPly(index, criterion, panel, float(place), float(time)))
    return max(found, key=lambda worst: worst.index, default=None)
