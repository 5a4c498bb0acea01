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
        self._seen: tuple[float, Array] | None = None  # time and place of the last state
        self._last: tuple[Array, float] | None = None  # velocity and length of the last step
        self._rates: tuple[Array, Array] = (np.zeros(0), np.zeros(0))

    def follow(self, state: State) -> tuple[Array, Array]:
        """Mean velocity of the last step, and the acceleration; zeros before there are any.

        To be called for every state of a run.
        """
        if self._seen is not None and state.time == self._seen[0]:
            return self._rates
        place = np.array(self._find(state))
        if self._seen is None:
            still = np.zeros_like(self._subtract(place, place))
            self._rates = still if self._last is None else self._last[0], still
        else:
            h = state.time - self._seen[0]
            velocity = self._subtract(place, self._seen[1]) / h
            acceleration = np.zeros_like(velocity)
            if self._last is not None:
                before, length = self._last
                acceleration = 2.0 * (velocity - before) / (h + length)
            self._last, self._rates = (velocity, h), (velocity, acceleration)
        self._seen = state.time, place
        return self._rates

    def save(self) -> RestartData:
        """Mean velocity and length of the last step, if there was one."""
        if self._last is None:
            return RestartData()
        return RestartData({"length": self._last[1]}, {"velocity": self._last[0].copy()})

    def restore(self, data: RestartData) -> None:
        """Resume after the saved step."""
        self._last = (data.arrays["velocity"].copy(), data.numbers["length"]) if data else None
