"""Gravity on all rigid and flexible bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.prescribed_force import ForceSum
from turbine_fenicsx.foundation.argument_checks import check_array


@dataclass(frozen=True, eq=False)
class Gravity:
    """Uniform, constant gravity.

    Args:
        acceleration: Acceleration in space [m/s^2], shape (3,), by default 9.81 downwards (-e2).
        name: Its name; it does no external work.

    Raises:
        ModelError: if the acceleration is not a vector.
    """

    acceleration: npt.ArrayLike = (0.0, -9.81, 0.0)
    name: str = "gravity"

    def __post_init__(self) -> None:
        words = "three numbers in m/s^2, such as (0.0, -9.81, 0.0)"
        check_array("acceleration of gravity", self.acceleration, (3,), words)

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add the acceleration."""
        forces.acceleration += np.asarray(self.acceleration, dtype=float)
