"""A wind that sets in smoothly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.forces.time_functions import Ramp
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import Inflow


@dataclass(frozen=True, eq=False)
class RampedInflow:
    """Another wind times a ramp that begins at t = 0.

    Args:
        inflow: The wind.
        duration: Time in which it sets in, positive [s].
    """

    inflow: Inflow
    duration: float

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`."""
        factor = Ramp(1.0, self.duration, smooth=True)(time)
        return np.asarray(factor * self.inflow.velocity(position, time))
