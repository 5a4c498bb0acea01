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
from turbine_fenicsx.time_stepping.recent_steps import RecentSteps

WEIGHTS: Array = np.array([4.0, -5.0, 0.0, 5.0, -4.0, 1.0])
"""Weights of r_{n-1}, r_{n-2}, ...: the coefficients of 1 - (1 - z)^5 (1 + z)."""


class Extrapolation:
    """The unknowns of the last steps, as long as these are equally long and without a gap."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self._steps = RecentSteps(len(WEIGHTS))

    def guess(self, time: float, dt: float) -> Array | None:
        """The unknowns of the step from a time by dt [s]; None where too little is known."""
        last = self._steps.before(time, dt)
        return WEIGHTS @ np.array(last) if last else None

    def add(self, time: float, dt: float, r: Array) -> None:
        """A step from a time by dt [s] was made, with these unknowns."""
        self._steps.add(time, dt, r)

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self._steps.forget()

    def save(self) -> RestartData:
        """The last steps; nothing if there are none."""
        steps = self._steps
        if not steps.values:
            return RestartData()
        return RestartData({"dt": steps.dt, "end": steps.end}, {"r": np.array(steps.values)})

    def restore(self, data: RestartData) -> None:
        """Resume after the saved steps."""
        self.forget()
        if data:
            self._steps.dt, self._steps.end = data.numbers["dt"], data.numbers["end"]
            self._steps.values = list(data.arrays["r"])
