"""Gravity, and the torques on the rotor and yaw bearings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.forces import Gravity, JointTorque
from turbine_fenicsx.forces.time_functions import Hat, Product, Ramp
from turbine_fenicsx.turbine.case.tables import LoadsCase
from turbine_fenicsx.turbine.component import Assembly, Component
from turbine_fenicsx.turbine.nacelle import ROTOR, YAW


def make_hat(loads: LoadsCase, ramp: float) -> Callable[[float], float]:
    """The course of all torques in time, of the height one: a hat, which may set in smoothly.

    Args:
        loads: Its duration.
        ramp: Time in which it sets in [s]; 0 for at once.
    """
    hat = Hat(1.0, loads.duration)
    return Product(hat, Ramp(1.0, ramp, smooth=True)) if ramp else hat


@dataclass(frozen=True)
class Loads(Component):
    """Gravity, and hat functions of torque on rotor and yaw, eq. (60)."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Torques are named after their bearings; gravity acts along -e2."""
        loads, hat = assembly.case.loads, make_hat(assembly.case.loads, assembly.case.time.ramp)
        return [
            Gravity((0.0, -loads.gravity, 0.0)),
            JointTorque(f"torque on {ROTOR}", ROTOR, loads.rotor_torque, hat),
            JointTorque(f"torque on {YAW}", YAW, loads.yaw_torque, hat),
        ]
