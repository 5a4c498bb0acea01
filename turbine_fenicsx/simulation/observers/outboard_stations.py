"""Parts of the loads on stations that act beyond sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.forces.line_source import StepLoads
from turbine_fenicsx.forces.section_loads import StationLine
from turbine_fenicsx.foundation.rotations import unit
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.cuts import Cut


class StationShares(NamedTuple):
    """Parts of stations beyond n sections.

    Attributes:
        shares: Parts of their lengths, shape (n, stations).
        shifts: From each station to the middle of its part, in the initial configuration, shape
            (n, stations, 3) [m].
    """

    shares: Array
    shifts: Array

    def sum_up(self, loads: StepLoads) -> Array:
        """Forces and moments about the origin, shape (2, n, 3)."""
        motion, f, m = loads.motion, loads.force, loads.moment
        shifts = np.einsum("sij,nsj->nsi", motion.axes, self.shifts)
        moments = np.cross(motion.position + shifts, f) + m
        return np.array([self.shares @ f, np.einsum("ns,nsi->ni", self.shares, moments)])


def share_stations(lines: Sequence[StationLine], cuts: Sequence[Cut]) -> StationShares:
    """Parts of stations beyond sections.

    A station stands for what lies between the middles to its neighbours, the first and last one for
    as much on their other side.
    """
    shares, shifts = [], []
    for cut in cuts:
        axis, share, shift = unit(cut.section.axis), [], []
        for line in lines:
            places = np.asarray(line.stations, dtype=float)[:, None] * unit(line.axis)
            d = cut.find_distances(np.asarray(line.origin, dtype=float) + places)
            middles = 0.5 * (d[1:] + d[:-1])
            ends = (2.0 * d[0] - middles[0], 2.0 * d[-1] - middles[-1]) if len(d) > 1 else d[[0, 0]]
            bounds = np.concatenate([ends[:1], middles, ends[1:]])
            low, high = np.minimum(bounds[1:], bounds[:-1]), np.maximum(bounds[1:], bounds[:-1])
            length = np.maximum(high - low, 1e-12)
            share.append(np.clip(high / length, 0.0, 1.0) * (line.copy == cut.section.copy))
            shift.append(0.5 * np.clip(-low, 0.0, length)[:, None] * axis)
        shares.append(np.concatenate(share))
        shifts.append(np.concatenate(shift))
    return StationShares(np.array(shares), np.array(shifts))
