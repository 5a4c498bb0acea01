"""Prescribed motion of a joint coordinate, a rheonomic constraint."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from turbine_fenicsx.joints.relation import check_motion


@dataclass(frozen=True, eq=False)
class PrescribedMotion:
    """A joint coordinate that follows a function of time, Phi = Theta - p(t).

    Its multiplier is the torque or force of the drive, whose work counts as external work.

    Args:
        coordinate: Name of the joint coordinate.
        motion: p(t) [rad or m]. A run from the initial state, where all joint coordinates are
            zero, needs p(0) = 0; another one a start in which the coordinate is p(0).

    Raises:
        ModelError: if p(0) is no number.
        TypeError: if the motion is not a function.
    """

    coordinate: str
    motion: Callable[[float], float]

    def __post_init__(self) -> None:
        check_motion(f"prescribed motion of {self.coordinate!r}", self.motion)

    @property
    def name(self) -> str:
        """Name under which its work is reported."""
        return f"motion of {self.coordinate}"

    @property
    def factors(self) -> Mapping[str, float]:
        """The one entry of its row of S."""
        return {self.coordinate: 1.0}
