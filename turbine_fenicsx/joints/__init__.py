"""Joints between rigid bodies, one file each."""

from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import Angle, Displacement, JointCoordinate
from turbine_fenicsx.joints.cylindrical import Cylindrical
from turbine_fenicsx.joints.planar import Planar
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.joints.prismatic import Prismatic
from turbine_fenicsx.joints.relation import JointRelation, Relation, gear_pair, screw
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.joints.rheonomic import Rheonomic
from turbine_fenicsx.joints.rigid import Rigid
from turbine_fenicsx.joints.spherical import Spherical
from turbine_fenicsx.joints.universal import Universal

__all__ = [
    "Angle",
    "Cylindrical",
    "Displacement",
    "Joint",
    "JointCoordinate",
    "JointRelation",
    "Planar",
    "PrescribedMotion",
    "Prismatic",
    "Relation",
    "Revolute",
    "Rheonomic",
    "Rigid",
    "Spherical",
    "Universal",
    "gear_pair",
    "screw",
]
