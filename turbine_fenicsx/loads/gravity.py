"""Gravity on all rigid and flexible bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.loads.base import Forces


@dataclass(frozen=True)
class Gravity:
    """Uniform, constant gravity.

    Args:
        acceleration: Acceleration in space [m/s^2], by default 9.81 downwards (-e2).
        name: Its name; it does no external work.
    """

    acceleration: tuple[float, float, float] = (0.0, -9.81, 0.0)
    name: str = "gravity"

    def add_to(self, forces: Forces, time: float) -> None:
        """Add the acceleration."""
        forces.acceleration += np.asarray(self.acceleration)
