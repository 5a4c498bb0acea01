"""Forces, one file each: springs and dampers, gravity, torques, loads on points and surfaces."""

from turbine_fenicsx.forces.element import BoundElement, Element, Layout, StepTimes
from turbine_fenicsx.forces.follower_force import FollowerForce
from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.forces.joint_damper import JointDamper
from turbine_fenicsx.forces.joint_spring import JointSpring
from turbine_fenicsx.forces.joint_torque import JointTorque
from turbine_fenicsx.forces.load import Forces, Load, SurfaceLoad
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.point_damper import PointDamper
from turbine_fenicsx.forces.point_force import PointForce
from turbine_fenicsx.forces.point_spring import PointSpring
from turbine_fenicsx.forces.pressure import Pressure
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.forces.surface_traction import SurfaceTraction
from turbine_fenicsx.forces.torque import Torque

__all__ = [
    "BoundElement",
    "Element",
    "FollowerForce",
    "Forces",
    "Gravity",
    "JointDamper",
    "JointSpring",
    "JointTorque",
    "Layout",
    "Load",
    "NodeForce",
    "PointDamper",
    "PointForce",
    "PointSpring",
    "Pressure",
    "StepTimes",
    "SurfaceLoad",
    "SurfacePoint",
    "SurfaceTraction",
    "Torque",
]
