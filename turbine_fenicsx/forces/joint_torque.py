"""External torque or force on a joint coordinate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from turbine_fenicsx.forces.prescribed_force import ForceSum
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_number
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True)
class JointTorque:
    """A torque about a joint axis, or a force along it, between the partners, eqs (22), (58).

    Args:
        name: Name under which its work is reported.
        coordinate: Name of the joint coordinate; that of the joint if it has only one.
        torque: Torque [N m] on an angle or force [N] on a displacement, positive in the sense of
            the coordinate.
        function: Factor as a function of time [s].

    Raises:
        ModelError: if the torque is not a number.
        TypeError: if the function is not one of time.
    """

    name: str
    coordinate: str
    torque: float
    function: Callable[[float], float] = ALWAYS

    def __post_init__(self) -> None:
        check_number(f"torque of {self.name!r}", self.torque)
        check_function(self.name, self.function)

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add the torque."""
        if self.coordinate not in forces.torques:
            known = sorted(forces.torques)
            raise ModelError(f"no joint coordinate {self.coordinate!r}; there are {known}")
        forces.torques[self.coordinate] += self.torque * self.function(time)
