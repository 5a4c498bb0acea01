"""Linear spring on a joint coordinate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.forces.force import BoundForce, Kind, Layout, LinearForce
from turbine_fenicsx.foundation.argument_checks import check_not_negative, check_number


@dataclass(frozen=True, eq=False)
class JointSpring:
    """V = k/2 (Theta - rest)^2; its force at the mean of a step conserves energy exactly.

    Args:
        name: Unique name.
        coordinate: Name of the joint coordinate.
        stiffness: k, not negative [N m/rad or N/m].
        rest: Where the spring is at rest [rad or m].

    Raises:
        ModelError: if the stiffness is negative, or the position at rest is not a number.
    """

    name: str
    coordinate: str
    stiffness: float
    rest: float = 0.0
    kind: Kind = "conservative"

    def __post_init__(self) -> None:
        check_not_negative(f"stiffness of {self.name!r}", self.stiffness)
        check_number(f"rest of {self.name!r}", self.rest)

    def bind(self, layout: Layout) -> BoundForce:
        """The spring with its coordinate numbered."""
        index = np.array([layout.coordinate(self.coordinate)])
        return LinearForce(index, stiffness=self.stiffness, rest=self.rest)
