"""First guess of a step from the steps before it.

A smooth motion is near a polynomial in the number of the step, but velocities and multipliers carry
an undamped alternating part besides, since the constraints hold at the ends of the steps only. With
the shift z r_n = r_{n-1}, polynomials of degree below five and (-1)^n are all that

    (1 - z)^5 (1 + z) r_n = 0

has as solutions; solved for r_n this is the guess. Its error is 2 dt^5 times the fifth derivative,
where five steps without the factor 1 + z would multiply the alternating part by 32.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

WEIGHTS: Array = np.array([4.0, -5.0, 0.0, 5.0, -4.0, 1.0])
"""Weights of r_{n-1}, r_{n-2}, ...: the coefficients of 1 - (1 - z)^5 (1 + z)."""


class Extrapolation:
    """The unknowns of the last steps, as long as these are equally long and without a gap."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self._dt = self._end = 0.0
        self._last: list[Array] = []  # newest first

    def guess(self, time: float, dt: float) -> Array | None:
        """The unknowns of the step from a time by dt [s]; None where too little is known."""
        enough = len(self._last) == len(WEIGHTS) and self._follows(time, dt)
        return WEIGHTS @ np.array(self._last) if enough else None

    def add(self, time: float, dt: float, r: Array) -> None:
        """A step from a time by dt [s] was made, with these unknowns."""
        if not self._follows(time, dt):
            self.forget()
        self._dt, self._end = dt, time + dt
        self._last = [r, *self._last[: len(WEIGHTS) - 1]]

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self._last = []

    def save(self) -> RestartData:
        """The last steps; nothing if there are none."""
        if not self._last:
            return RestartData()
        return RestartData({"dt": self._dt, "end": self._end}, {"r": np.array(self._last)})

    def restore(self, data: RestartData) -> None:
        """Go on after the steps that were saved."""
        self.forget()
        if data:
            self._dt, self._end = data.numbers["dt"], data.numbers["end"]
            self._last = list(data.arrays["r"])

    def _follows(self, time: float, dt: float) -> bool:
        """Whether a step continues the last ones, except for round-off."""
        return max(abs(time - self._end), abs(dt - self._dt)) <= 1e-6 * dt
