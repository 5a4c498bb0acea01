"""Loads, one file each."""

from turbine_fenicsx.loads.base import Forces, Load
from turbine_fenicsx.loads.gravity import Gravity
from turbine_fenicsx.loads.joint_torque import JointTorque

__all__ = ["Forces", "Gravity", "JointTorque", "Load"]
