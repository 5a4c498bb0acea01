"""Distances of blade tips from the yaw axis, the clearance of blade and tower in OpenFAST.

The yaw axis moves with the nacelle. Tips below the yaw bearing have their distance from the axis,
tips above it that from the bearing. Without the radius of the tower this is no gap yet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import NACELLE
from turbine_fenicsx.simulation.observers.tips import Tip, Tips
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.components.component import Turbine


class YawDistances:
    """Distances of tips from the yaw axis. Collective.

    Args:
        turbine: The turbine, whose yaw bearing starts in the origin and turns about e2.
    """

    def __init__(self, turbine: Turbine, tips: Sequence[Tip]) -> None:
        nacelle = turbine.part(NACELLE)
        seen = [replace(tip, carrier=nacelle, axes=np.eye(3)) for tip in tips]
        self._tips = Tips(turbine.system, seen)
        self._starts = self._tips.starts

    def at(self, snapshot: Snapshot) -> Array:
        """Distances at a snapshot [m], shape (tips,). Collective."""
        side, height, ahead = (self._starts + self._tips.at(snapshot)).T
        distances: Array = np.hypot(np.hypot(side, ahead), np.maximum(height, 0.0))
        return distances
