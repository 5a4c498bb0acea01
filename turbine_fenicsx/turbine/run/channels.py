"""Time series of a turbine: which columns ``history.csv`` and ``history.out`` have."""

from __future__ import annotations

from turbine_fenicsx.simulation.observers.history import (
    angle_channel,
    energy_channel,
    numerics_channel,
    work_channel,
)
from turbine_fenicsx.simulation.observers.tips import stress_channel
from turbine_fenicsx.time_stepping.stepper import Stepper
from turbine_fenicsx.turbine.components.component import Channels, Turbine

CONVENTIONS = (
    "Azimuth is 0 when blade 1 points up (AzimB1Up = 0); RotSpeed is the mean of the step that "
    "ends at the time of the row, loads are those of the last two"
)
"""Line in the head of ``history.out``."""


def turbine_channels(turbine: Turbine, stepper: Stepper, stress: bool) -> Channels:
    """Columns of both time series from left to right. Collective.

    Args:
        turbine: The turbine.
        stepper: What integrates it.
        stress: Whether the largest stress has a column, if anything is flexible.
    """
    system = turbine.system
    found = [component.channels(turbine) for component in turbine.components]
    return Channels(
        history=[
            energy_channel(),
            angle_channel(system),
            *(channel for each in found for channel in each.history),
            *([stress_channel(system)] if stress and system.flexible_bodies else []),
            work_channel(stepper),
            numerics_channel(),
        ],
        openfast=[channel for each in found for channel in each.openfast],
    )
