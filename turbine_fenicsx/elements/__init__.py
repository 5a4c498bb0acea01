"""Force elements on rigid bodies and joint coordinates, one file each."""

from turbine_fenicsx.elements.base import BoundElement, Element, Layout, Step
from turbine_fenicsx.elements.joint_damper import JointDamper
from turbine_fenicsx.elements.joint_spring import JointSpring
from turbine_fenicsx.elements.point_damper import PointDamper
from turbine_fenicsx.elements.point_spring import PointSpring

__all__ = [
    "BoundElement",
    "Element",
    "JointDamper",
    "JointSpring",
    "Layout",
    "PointDamper",
    "PointSpring",
    "Step",
]
