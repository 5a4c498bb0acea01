"""Three rigid blades on the hub (section 2 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.postprocessing.conventions import BLADES, HUB
from turbine_fenicsx.turbine.component import Assembly, Component, Turbine
from turbine_fenicsx.turbine.rotor_plan import AZIMUTHS
from turbine_fenicsx.turbine.surfaces import blade_surface


@dataclass(frozen=True)
class RigidBlades(Component):
    """Three rigid blades, eqs (29)-(32); the pitch bearings hold them on the hub."""

    def parts(self, assembly: Assembly) -> list[RigidBody]:
        """Bodies ``blade_1``, ``blade_2``, ``blade_3``."""
        p, hub = assembly.case.turbine.parameters(), assembly.part(HUB)
        turns = [rotation_about(E3, azimuth) for azimuth in AZIMUTHS]
        centre = np.asarray(hub.position)
        return [
            RigidBody(
                name,
                p.blade.mass,
                p.blade.euler,
                position=centre + arm * (R @ E2),
                directors=R,
            )
            for name, R, arm in zip(BLADES, turns, p.blade_arms, strict=True)
        ]

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """Skins with elliptic sections."""
        layout, blade = turbine.rotor.layout, turbine.rotor.blade
        centre = np.asarray(turbine.part(HUB).position)
        return [
            blade_surface(
                turbine.part(name), blade, centre, layout.frame(k)[0], turbine.numbers[name]
            )
            for k, name in enumerate(BLADES, start=1)
        ]
