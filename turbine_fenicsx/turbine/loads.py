"""Gravity, and the torques on the rotor and yaw bearings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.forces import Gravity, JointTorque
from turbine_fenicsx.forces.time_functions import Hat
from turbine_fenicsx.turbine.component import Assembly, Component
from turbine_fenicsx.turbine.nacelle import ROTOR, YAW


@dataclass(frozen=True)
class Loads(Component):
    """Gravity, and hat functions of torque on rotor and yaw, eq. (60)."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Torques are named after their bearings; gravity acts along -e2."""
        loads = assembly.case.loads
        hat = Hat(1.0, loads.duration)
        return [
            Gravity((0.0, -loads.gravity, 0.0)),
            JointTorque(f"torque on {ROTOR}", ROTOR, loads.rotor_torque, hat),
            JointTorque(f"torque on {YAW}", YAW, loads.yaw_torque, hat),
        ]
