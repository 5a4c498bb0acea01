"""Forces, one file each: springs and dampers, gravity, torques, forces on points and surfaces."""

from turbine_fenicsx.forces.follower_force import FollowerForce
from turbine_fenicsx.forces.force import BoundForce, Force, Layout, StepTimes
from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.forces.joint_damper import JointDamper
from turbine_fenicsx.forces.joint_spring import JointSpring
from turbine_fenicsx.forces.joint_torque import JointTorque
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.forces.point_damper import PointDamper
from turbine_fenicsx.forces.point_force import PointForce
from turbine_fenicsx.forces.point_spring import PointSpring
from turbine_fenicsx.forces.prescribed_force import ForceSum, PrescribedForce, SurfaceForce
from turbine_fenicsx.forces.pressure import Pressure
from turbine_fenicsx.forces.rigid_section_loads import RigidSectionLoads, RigidStations
from turbine_fenicsx.forces.section_loads import LineLoad, SectionLoads, SectionMotion, StationLine
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.forces.surface_traction import SurfaceTraction
from turbine_fenicsx.forces.torque import Torque

__all__ = [
    "BoundForce",
    "FollowerForce",
    "Force",
    "ForceSum",
    "Gravity",
    "JointDamper",
    "JointSpring",
    "JointTorque",
    "Layout",
    "LineLoad",
    "NodeForce",
    "PointDamper",
    "PointForce",
    "PointSpring",
    "PrescribedForce",
    "Pressure",
    "RigidSectionLoads",
    "RigidStations",
    "SectionLoads",
    "SectionMotion",
    "StationLine",
    "StepTimes",
    "SurfaceForce",
    "SurfacePoint",
    "SurfaceTraction",
    "Torque",
]
