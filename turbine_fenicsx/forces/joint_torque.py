"""External torque or force on a joint coordinate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from turbine_fenicsx.forces.load import Forces
from turbine_fenicsx.foundation.checks import check_function
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True)
class JointTorque:
    """A torque about a joint axis, or a force along it, between the partners, eqs (22), (58).

    Args:
        joint: Name of a joint coordinate; that of the joint if it has only one.
        torque: Torque [N m] on an angle or force [N] on a displacement as a function of time [s];
            positive in the sense of the coordinate.

    Raises:
        TypeError: for what is no function of time.
    """

    joint: str
    torque: Callable[[float], float]

    def __post_init__(self) -> None:
        check_function(self.name, self.torque)

    @property
    def name(self) -> str:
        """Name under which its work is reported."""
        return f"torque on {self.joint}"

    def add_to(self, forces: Forces, time: float) -> None:
        """Add the torque."""
        if self.joint not in forces.torques:
            known = sorted(forces.torques)
            raise ModelError(f"no joint coordinate {self.joint!r}; there are {known}")
        forces.torques[self.joint] += self.torque(time)
