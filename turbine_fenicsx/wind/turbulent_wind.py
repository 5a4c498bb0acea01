"""A mean wind and the turbulence of a box that it carries along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.turbulence import TurbulenceField


@dataclass(frozen=True, eq=False)
class TurbulentWind:
    """A mean wind and the fluctuations that it carries along."""

    mean: SteadyWind
    fluctuations: TurbulenceField

    def list_mistakes(self, end: float, centre: Array, radius: float) -> list[str]:
        """As `TurbulenceField.list_mistakes`."""
        return self.fluctuations.list_mistakes(end, centre, radius)

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`."""
        fluctuation = self.fluctuations.velocity(position, time)
        return np.asarray(self.mean.velocity(position, time) + fluctuation)


def carry_box(
    values: npt.NDArray[np.float32],
    spacing: Sequence[float],
    mean: SteadyWind,
    periodic: bool = True,
) -> TurbulentWind:
    """A mean wind with the fluctuations of a box, whose middle is at its hub height.

    Args:
        values: Fluctuations, shape (n_x, n_z, n_y, 3), y to the left looking downwind [m/s].
        spacing: Distances between points along x, y and z [m].
        mean: The mean wind, along x.
        periodic: Whether the box restarts when it has passed. Another one leads by the time that
            half its width takes, so that all of the rotor lies within it at t = 0.
    """
    _, n_z, n_y, _ = values.shape
    dx, dy, dz = spacing
    y = (np.arange(n_y) - 0.5 * (n_y - 1)) * dy
    z = mean.hub_height + (np.arange(n_z) - 0.5 * (n_z - 1)) * dz
    lead = 0.0 if periodic else float(y[-1]) / mean.speed
    one, none = np.ones(3), np.zeros(3)
    dt = dx / mean.speed
    return TurbulentWind(
        mean, TurbulenceField(values, one, none, dt, y, z, mean.speed, bool(periodic), lead)
    )
