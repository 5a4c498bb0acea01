"""Functions of time for loads."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hat:
    """Triangle from zero at t = 0 to ``peak`` at half the ``duration`` and back, eq. (60).

    Args:
        peak: Largest value, of any sign and unit.
        duration: Duration [s], positive.

    Raises:
        ValueError: for a duration that is not positive.
    """

    peak: float
    duration: float = 3.0

    def __post_init__(self) -> None:
        """Check the duration."""
        if not self.duration > 0.0:
            raise ValueError(f"duration of a hat function must be positive, got {self.duration} s")

    def __call__(self, time: float) -> float:
        """Value at a time [s]."""
        return self.peak * max(0.0, 1.0 - abs(2.0 * time / self.duration - 1.0))


@dataclass(frozen=True)
class Constant:
    """The same value at all times.

    Args:
        value: The value, of any unit.
    """

    value: float

    def __call__(self, time: float) -> float:
        """The value."""
        return self.value
