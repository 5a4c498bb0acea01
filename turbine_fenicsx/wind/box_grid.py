"""Grid of a turbulence box: planes across the wind, which reach the turbine one after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

MAX_BYTES = 2**30
"""Larger boxes are not made; Mann's model needs some ten times as much meanwhile."""

MAX_PLANES = 1e9
"""More are too many for any box, and some computers cannot count them."""


@dataclass(frozen=True)
class BoxGrid:
    """Points of a turbulence box that repeats itself along the wind.

    Args:
        points: Number of points along the wind, across it and upwards; four or more, and two.
        spacing: Distances between them [m].

    Raises:
        ModelError: for too few points, for distances that are not positive, or more than 1 GiB.
    """

    points: tuple[int, int, int]
    spacing: tuple[float, float, float]

    def __post_init__(self) -> None:
        if not all(n >= least for n, least in zip(self.points, (4, 2, 2), strict=True)):
            raise ModelError(
                f"points of a turbulence box must be 4, 2 and 2 or more, got {self.points}"
            )
        if not all(0.0 < d < np.inf for d in self.spacing):
            raise ModelError(f"spacing of a turbulence box must be positive, got {self.spacing}")
        if (size := 12.0 * float(np.prod(self.points, dtype=float))) > MAX_BYTES:
            raise ModelError(
                f"a turbulence box of {size / 2**30:.3g} GiB is too large, at most 1: take fewer "
                "points, larger steps or less time"
            )

    @staticmethod
    def covering(
        duration: float, time_step: float, speed: float, width: float, across: int
    ) -> BoxGrid:
        """A square grid that lasts for a duration, or little longer.

        Args:
            duration: Time after which it repeats itself [s].
            time_step: Time between two planes [s].
            speed: Mean wind [m/s].
            width: And height [m].
            across: Points across the wind, and upwards.
        """
        half = min(0.5 * duration / time_step, MAX_PLANES)
        n = 2 * scipy.fft.next_fast_len(max(2, int(np.ceil(half - 1e-9))))
        side = width / (across - 1)
        return BoxGrid((n, across, across), (speed * time_step, side, side))

    @property
    def sides(self) -> tuple[Array, Array]:
        """Places across the wind and upwards, from the middle of the box, rising [m]."""
        _, y, z = (
            (np.arange(n) - 0.5 * (n - 1)) * d
            for n, d in zip(self.points, self.spacing, strict=True)
        )
        return y, z

    @property
    def waves(self) -> Array:
        """Wave numbers along the wind, without 0 and the largest, shape (n/2 - 1,) [rad/m]."""
        n, length = self.points[0], self.points[0] * self.spacing[0]
        return np.asarray(2.0 * np.pi / length * np.arange(1, (n + 1) // 2))
