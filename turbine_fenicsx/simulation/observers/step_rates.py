"""Accelerations from places or rotations at the ends of steps.

Velocities at the ends of steps carry an alternating part that no sensor would have. The mean
velocities of two steps, (x_1 - x_0)/h_1 and (x_2 - x_1)/h_2, belong to their middles, so that

    a = 2 (v_2 - v_1)/(h_1 + h_2)

is an acceleration at the time between them, of second order.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State


class StepRates:
    """Mean velocities of steps and their changes, which survive a restart.

    Args:
        place: Where something is in a state; called on all ranks.
        subtract: (new, old) -> the way from old to new; for rotations the vector of the rotation.
    """

    def __init__(
        self,
        place: Callable[[State], Array],
        subtract: Callable[[Array, Array], Array] = np.subtract,
    ) -> None:
        self._find, self._subtract = place, subtract
        self._place: Array | None = None
        self._time = 0.0
        self._last: tuple[Array, float] | None = None  # velocity and length of the last step
        self._rates: tuple[Array, Array] | None = None

    def at(self, snapshot: Snapshot) -> tuple[Array, Array]:
        """Mean velocity of the last step, and the acceleration; zeros before there are any.

        To be called for every snapshot of a run.
        """
        return self.follow(snapshot.state)

    def follow(self, state: State) -> tuple[Array, Array]:
        """As `at`, for every state of a run."""
        if self._place is not None and self._rates is not None and state.time == self._time:
            return self._rates
        place = np.array(self._find(state))
        start = self._place is None
        way = self._subtract(place, place if self._place is None else self._place)
        velocity = acceleration = np.zeros_like(way)
        if start:
            velocity = velocity if self._last is None else self._last[0]
        else:
            h = state.time - self._time
            velocity = way / h
            if self._last is not None:
                before, length = self._last
                acceleration = 2.0 * (velocity - before) / (h + length)
            self._last = velocity, h
        self._place, self._time, self._rates = place, state.time, (velocity, acceleration)
        return self._rates

    def save(self) -> RestartData:
        """Mean velocity and length of the last step, if there was one."""
        if self._last is None:
            return RestartData()
        return RestartData({"length": self._last[1]}, {"velocity": self._last[0].copy()})

    def restore(self, data: RestartData) -> None:
        """Resume after the saved step."""
        self._last = (data.arrays["velocity"].copy(), data.numbers["length"]) if data else None
