"""Linear damper on a joint coordinate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.forces.force import BoundForce, Kind, Layout, LinearForce
from turbine_fenicsx.foundation.argument_checks import check_not_negative


@dataclass(frozen=True, eq=False)
class JointDamper:
    """The force -d (Theta_1 - Theta_0)/dt; a step dissipates exactly d (Theta_1 - Theta_0)^2/dt.

    Args:
        name: Unique name.
        coordinate: Name of the joint coordinate.
        damping: d, not negative [N m s/rad or N s/m].

    Raises:
        ModelError: for a negative damping.
    """

    name: str
    coordinate: str
    damping: float
    kind: Kind = "dissipative"

    def __post_init__(self) -> None:
        check_not_negative(f"damping of {self.name!r}", self.damping)

    def bind(self, layout: Layout) -> BoundForce:
        """The damper with its coordinate numbered."""
        return LinearForce(np.array([layout.coordinate(self.coordinate)]), damping=self.damping)
