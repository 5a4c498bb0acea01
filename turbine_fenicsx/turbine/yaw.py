"""The yaw bearing: locked, or turned by a drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.control.drives import YawDrive
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.postprocessing.conventions import OPENFAST_SIGNS
from turbine_fenicsx.turbine.component import Assembly, Component
from turbine_fenicsx.turbine.nacelle import YAW


@dataclass(frozen=True)
class Yaw(Component):
    """A drive of the yaw bearing, which stands still unless it is commanded."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """A prescribed motion, unless the nacelle turns freely."""
        if assembly.case.yaw.drive == "free":
            return []
        return [PrescribedMotion(YAW, YawDrive(OPENFAST_SIGNS[YAW]))]
