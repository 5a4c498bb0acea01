"""Brakes: joint coordinates of the turbine that do not move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.turbine.component import Assembly, Component


@dataclass(frozen=True)
class Brakes(Component):
    """Prescribed motions that keep joint coordinates at zero.

    Args:
        coordinates: Names of the joint coordinates, for example ``"yaw"``.
    """

    coordinates: tuple[str, ...]

    def parts(self, assembly: Assembly) -> list[Any]:
        """A prescribed motion for each coordinate that none has already."""
        driven = {p.coordinate for p in assembly.parts if isinstance(p, PrescribedMotion)}
        return [
            PrescribedMotion(name, lambda _: 0.0) for name in self.coordinates if name not in driven
        ]
