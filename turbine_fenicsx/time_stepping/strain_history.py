"""Strain coordinates at the starts of the last steps, and what the next step will make of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.types import Array

EQUAL_STEPS = 1e-6
"""Maximum difference of two steps of equal length, relative to it."""

WEIGHTS = ((1.0,), (0.0, 1.0), (1.0, 1.0, -1.0))
"""Weights of the values of the last steps, newest first, that extrapolate them to the next."""


class StrainHistory:
    """Strain coordinates at t_n, t_{n-1} and t_{n-2}; a repeated step leaves no trace."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._values: list[Array] = []
        self._dt = 0.0

    def start_step(self, times: StepTimes, c: Array) -> None:
        """A step begins at t_n with the strain coordinates c."""
        start, self._dt = times.end - times.dt, times.dt
        near = EQUAL_STEPS * times.dt
        known = [k for k, time in enumerate(self._times) if time < start - near]
        self._times = [start, *(self._times[k] for k in known)][:3]
        self._values = [c, *(self._values[k] for k in known)][:3]

    def expect(self) -> Array:
        """Strain coordinates to be expected at t_{n+1}."""
        gaps = [a - b for a, b in zip(self._times, self._times[1:], strict=False)]
        equal = 0
        while equal < len(gaps) and abs(gaps[equal] - self._dt) <= EQUAL_STEPS * self._dt:
            equal += 1
        weights = WEIGHTS[min(equal, 2)]
        found: Array = np.tensordot(weights, np.array(self._values[: len(weights)]), 1)
        return found

    def save(self) -> tuple[list[float], list[Array]]:
        """Times and values, newest first."""
        return list(self._times), [c.copy() for c in self._values]

    def restore(self, times: Sequence[float], values: Sequence[Array]) -> None:
        """Continue after these."""
        self._times, self._values = list(times), list(values)
