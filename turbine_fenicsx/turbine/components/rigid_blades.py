"""Three rigid blades on the hub (section 2 of the paper), or those of a windIO file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.turbine.blades.surfaces import tube
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.root_channels import root_channels

POINTS_AROUND, STATIONS = 24, 25
"""Points of the skin around a section and along the span, for pictures."""


@dataclass(frozen=True)
class RigidBlades(Component):
    """Three rigid blades, eqs (29)-(32), or with the inertia of the layup of ``turbine.file``.

    The pitch bearings hold them on the hub.
    """

    def parts(self, assembly: Assembly) -> list[RigidBody]:
        """Bodies ``blade_1``, ``blade_2``, ``blade_3``. Collective."""
        p, layout = assembly.case.turbine.parameters(), assembly.rotor.layout
        inertia = on_rank0(assembly.comm, assembly.rotor.blades.find_inertia)
        if inertia is not None:
            assert inertia.tensor is not None
            return [
                RigidBody.from_inertia(
                    name,
                    inertia.mass,
                    inertia.tensor,
                    position=layout.place(np.array([inertia.centre]), k)[0],
                    axes=layout.frame(k).T,
                )
                for k, name in enumerate(BLADES, start=1)
            ]
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

    def channels(self, turbine: Turbine) -> Channels:
        """Root forces and moments: what the blades exert on the hub, as of flexible blades."""
        return root_channels(turbine)

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """Skins of the blades."""
        layout, numbers, blades = turbine.rotor.layout, turbine.numbers, turbine.rotor.blades
        rings = blades.rings(STATIONS, POINTS_AROUND)
        return [
            RigidSurface(turbine.part(name), *tube(layout.place(rings, k)), numbers[name])
            for k, name in enumerate(BLADES, start=1)
        ]
