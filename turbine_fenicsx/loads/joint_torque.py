"""External torque on a joint angle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from turbine_fenicsx.loads.base import Forces


@dataclass(frozen=True)
class JointTorque:
    """A torque between the partners of a joint, about the joint axis, eqs (22), (58).

    Args:
        joint: Name of a joint with an angle.
        torque: Torque [N m] as a function of time [s]; positive in the sense of the angle.
    """

    joint: str
    torque: Callable[[float], float]

    def add_to(self, forces: Forces, time: float) -> None:
        """Add the torque."""
        if self.joint not in forces.torques:
            raise ValueError(f"no joint angle {self.joint!r}; there are {sorted(forces.torques)}")
        forces.torques[self.joint] += self.torque(time)
