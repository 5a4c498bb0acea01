"""Data of the last steps, as long as these are equally long and without a gap."""

from __future__ import annotations

from turbine_fenicsx.foundation.types import Array


class RecentSteps:
    """Values of the last steps, as long as each continues the one before.

    Args:
        most: Number of steps that are kept.

    Attributes:
        values: Those of each step, newest first.
        dt: Length of the steps [s].
        end: Time of their end [s].
    """

    def __init__(self, most: int) -> None:
        """Nothing is known yet."""
        self._most = most
        self.dt = self.end = 0.0
        self.values: list[Array] = []

    def before(self, time: float, dt: float) -> list[Array]:
        """Values of the steps that a step from a time by dt [s] continues; empty unless full."""
        full = len(self.values) == self._most and self._follows(time, dt)
        return self.values if full else []

    def add(self, time: float, dt: float, values: Array) -> None:
        """A step from a time by dt [s] was made."""
        if not self._follows(time, dt):
            self.forget()
        self.dt, self.end = dt, time + dt
        self.values = [values, *self.values[: self._most - 1]]

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self.values = []

    def _follows(self, time: float, dt: float) -> bool:
        """Whether a step continues the last ones, except for round-off."""
        return max(abs(time - self.end), abs(dt - self.dt)) <= 1e-6 * dt
