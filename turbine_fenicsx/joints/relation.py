"""Relations between joint coordinates: gears, screws, differentials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from typing import Protocol, runtime_checkable

from turbine_fenicsx.foundation.argument_checks import check_number, describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import describe_kind, name_errors


@runtime_checkable
class Relation(Protocol):
    """A row of S Theta = p(t), one linear equation between joint coordinates.

    Its multiplier pi acts on the coordinates with the generalised forces -S^T pi.
    """

    @property
    def name(self) -> str:
        """Name under which its work is reported."""

    @property
    def factors(self) -> Mapping[str, float]:
        """Entries of the row S by the names of the joint coordinates."""

    @property
    def motion(self) -> Callable[[float], float] | None:
        """p(t); None for zero at all times, where the relation does no work."""


@dataclass(frozen=True, eq=False)
class JointRelation:
    """A sum of joint coordinates, each with a factor, that is zero or follows a function of time.

    Args:
        name: Unique name.
        factors: Factors by the names of the joint coordinates [1, 1/m, ...], not zero.
        motion: p(t), in a run p(0) belongs to its start; None for zero.

    Raises:
        ModelError: if there is no factor, a factor is zero or not a number, or p(0) is not a
            number.
        TypeError: if the motion is not a function.
    """

    name: str
    factors: Mapping[str, float]
    motion: Callable[[float], float] | None = None

    def __post_init__(self) -> None:
        if not self.factors:
            raise ModelError(f"relation {self.name!r} needs the factor of a joint coordinate")
        for coordinate, factor in self.factors.items():
            if check_number(f"factor of {coordinate!r} in {self.name!r}", factor) == 0.0:
                raise ModelError(f"factor of {coordinate!r} in {self.name!r} must not be zero")
        if self.motion is not None:
            check_motion(f"motion of {self.name!r}", self.motion)


def gear_pair(name: str, driving: str, driven: str, ratio: float) -> JointRelation:
    """Two angles that turn at a fixed ratio, driven = ratio * driving.

    Args:
        name: Unique name.
        driving: Joint coordinate of the one.
        driven: Joint coordinate of the other.
        ratio: Turns of the driven for one turn of the driving; negative for an external gear pair,
            whose wheels turn in opposite senses.
    """
    return JointRelation(name, {driven: 1.0, driving: -check_number(f"ratio of {name!r}", ratio)})


def screw(name: str, angle: str, displacement: str, lead: float) -> JointRelation:
    """A displacement that follows an angle, displacement = lead * angle / (2 pi).

    Args:
        name: Unique name.
        angle: Joint coordinate of the rotation.
        displacement: Joint coordinate of the translation.
        lead: Displacement for one turn [m].
    """
    pitch = check_number(f"lead of {name!r}", lead) / (2.0 * pi)
    return JointRelation(name, {displacement: 1.0, angle: -pitch})


def check_motion(what: str, motion: Callable[[float], float]) -> None:
    """Raise an error unless a motion is a function of time that is a number at t = 0."""
    if not callable(motion):
        raise TypeError(f"the {what} must be a function of time, got {describe(motion)}")
    with name_errors(f"{what}, {describe_kind(motion)}, at t = 0"):
        start = motion(0.0)
    check_number(f"{what} at t = 0", start)
