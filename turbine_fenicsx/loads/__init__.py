"""Loads, one file each."""

from turbine_fenicsx.loads.base import Forces, Load, SurfaceLoad
from turbine_fenicsx.loads.follower_force import FollowerForce
from turbine_fenicsx.loads.gravity import Gravity
from turbine_fenicsx.loads.joint_torque import JointTorque
from turbine_fenicsx.loads.node_force import NodeForce
from turbine_fenicsx.loads.point_force import PointForce
from turbine_fenicsx.loads.pressure import Pressure
from turbine_fenicsx.loads.surface_traction import SurfaceTraction
from turbine_fenicsx.loads.torque import Torque

__all__ = [
    "FollowerForce",
    "Forces",
    "Gravity",
    "JointTorque",
    "Load",
    "NodeForce",
    "PointForce",
    "Pressure",
    "SurfaceLoad",
    "SurfaceTraction",
    "Torque",
]
