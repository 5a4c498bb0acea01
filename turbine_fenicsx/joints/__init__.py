"""Joints between rigid bodies, one file each."""

from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.revolute import Revolute

__all__ = ["Joint", "Revolute"]
