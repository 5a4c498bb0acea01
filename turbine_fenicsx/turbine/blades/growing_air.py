"""Air on the stations of a blade that grows with time, with directions fixed in space.

Loads act on the skin as in a run, so that thin walls are bent by them as they are there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

SUBDIVISIONS = 20
"""Number of intervals between two stations in which loads are summed up."""


@dataclass(eq=False)
class GrowingAir:
    """A `LineLoad` on stations: line loads, shared out between the two stations beside them.

    Args:
        stations: Distances of the stations along the span, shape (n,) [m].
        along: Distances at which the loads are known, rising, shape (m,) [m].
        places: Where they act, shape (m, 3) [m].
        forces: Forces for each length, shape (m, 3) [N/m].
        moments: Moments for each length about the places, shape (m, 3) [N].
        function: Factor as a function of time [s].
    """

    stations: Array
    along: Array
    places: Array
    forces: Array
    moments: Array
    function: Callable[[float], float]
    _summed: tuple[Array, Array] | None = field(default=None, init=False)

    def start_step(self, times: StepTimes) -> None:
        """Nothing changes with steps."""

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """The loads at a time; see `LineLoad.loads`."""
        if self._summed is None:
            self._summed = self._sum_up(motion.initial)
        factor = self.function(time)
        return factor * self._summed[0], factor * self._summed[1]

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """Nothing moves on."""

    def save(self) -> RestartData:
        """Nothing is kept."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """Nothing was kept."""

    def _sum_up(self, centres: Array) -> tuple[Array, Array]:
        """Forces on the stations, and moments about their centres."""
        s, ends = self.stations, self.along[[0, -1]]
        knots = np.concatenate([[ends[0]], s[(s > ends[0]) & (s < ends[1])], [ends[1]]])
        part = (np.arange(SUBDIVISIONS) + 0.5) / SUBDIVISIONS
        middles = (knots[:-1, None] + np.diff(knots)[:, None] * part).ravel()
        lengths = np.repeat(np.diff(knots) / SUBDIVISIONS, SUBDIVISIONS)
        x, f, m = (self._interpolate(y, middles) for y in (self.places, self.forces, self.moments))
        # hat functions of the stations, constant beyond the ends
        hats = np.array([np.interp(middles, s, e) for e in np.eye(len(s))]) * lengths
        F = hats @ f
        return F, hats @ (m + np.cross(x, f)) - np.cross(centres, F)

    def _interpolate(self, values: Array, places: Array) -> Array:
        """Values at distances along the span, shape (k, 3)."""
        return np.stack([np.interp(places, self.along, column) for column in values.T], axis=1)
