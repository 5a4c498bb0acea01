"""Prescribed motion of a joint coordinate, a rheonomic constraint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from turbine_fenicsx.foundation.checks import describe
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True, eq=False)
class PrescribedMotion:
    """A joint coordinate that follows a function of time, Phi = Theta - p(t).

    Its multiplier is the torque or force of the drive, whose work counts as external work.

    Args:
        coordinate: Name of the joint coordinate.
        motion: p(t) [rad or m]; zero at t = 0, where all joint coordinates are zero.

    Raises:
        ModelError: if p(0) is not zero.
        TypeError: for what is no function.
    """

    coordinate: str
    motion: Callable[[float], float]

    def __post_init__(self) -> None:
        if not callable(self.motion):
            raise TypeError(
                f"the prescribed motion of {self.coordinate!r} must be a function of time, "
                f"got {describe(self.motion)}"
            )
        if not abs(self.motion(0.0)) <= 1e-12:
            raise ModelError(
                f"the prescribed motion of {self.coordinate!r} must be zero at t = 0, "
                f"got {self.motion(0.0):g}"
            )

    @property
    def name(self) -> str:
        """Name under which its work is reported."""
        return f"motion of {self.coordinate}"
