"""Three rigid blades on the hub (section 2 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.postprocessing.conventions import BLADES
from turbine_fenicsx.turbine.component import Assembly, Component, Turbine
from turbine_fenicsx.turbine.solid_blades import SolidBlades
from turbine_fenicsx.turbine.surfaces import blade_surface


@dataclass(frozen=True)
class RigidBlades(Component):
    """Three rigid blades, eqs (29)-(32); the pitch bearings hold them on the hub."""

    def parts(self, assembly: Assembly) -> list[RigidBody]:
        """Bodies ``blade_1``, ``blade_2``, ``blade_3``."""
        p, layout = assembly.case.turbine.parameters(), assembly.rotor.layout
        return [
            RigidBody(
                name,
                p.blade.mass,
                p.blade.euler,
                position=layout.point_on_span(k, arm),
                directors=layout.directors(k),
            )
            for k, (name, arm) in enumerate(zip(BLADES, p.blade_arms, strict=True), start=1)
        ]

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """Skins with elliptic sections."""
        layout, numbers = turbine.rotor.layout, turbine.numbers
        shape = SolidBlades.of(turbine.case).geometry
        return [
            blade_surface(turbine.part(name), shape, layout, k, numbers[name])
            for k, name in enumerate(BLADES, start=1)
        ]
