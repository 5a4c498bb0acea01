"""Nacelle and hub, and the yaw and rotor bearings (section 2 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.rotations import E2, E3
from turbine_fenicsx.joints import Revolute
from turbine_fenicsx.postprocessing.conventions import HUB, NACELLE, OPENFAST_SIGNS
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.surfaces import hub_surface, nacelle_surface

YAW, ROTOR = "yaw", "rotor"
"""Names of the bearings and of their angles."""

SUPPORT = "tower_top"
"""Rigid body that carries the yaw bearing if it stands already; else the ground carries it."""


@dataclass(frozen=True)
class Nacelle(Component):
    """Nacelle, hub, and the yaw and rotor bearings, eqs (27), (28)."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Bodies ``nacelle`` and ``hub``, joints ``yaw`` and ``rotor``; see `SUPPORT`."""
        p = assembly.case.turbine.parameters()
        nacelle = RigidBody(NACELLE, p.nacelle.mass, p.nacelle.euler)
        hub = RigidBody(HUB, p.hub.mass, p.hub.euler, position=-p.hub_distance * E3)
        support = assembly.find(SUPPORT)
        yaw = Revolute(YAW, support, nacelle, point=(0.0, 0.0, 0.0), axis=-E2, reference=E3)
        rotor = Revolute(ROTOR, nacelle, hub, point=hub.position, axis=E3, reference=E2)
        return [nacelle, hub, yaw, rotor]

    def channels(self, turbine: Turbine) -> Channels:
        """Azimuth [0, 360), rotor speed and yaw for OpenFAST's readers.

        Azimuth and speed count positive about the shaft, downwind; the nacelle's yaw about the
        upward vertical, opposite to the paper's.
        """
        coordinates = turbine.system.angle_names
        rotor, yaw = coordinates.index(ROTOR), coordinates.index(YAW)

        def values(s: Snapshot) -> list[float]:
            azimuth, heading = (
                float(OPENFAST_SIGNS[name] * np.degrees(s.state.angles[k]))
                for name, k in ((ROTOR, rotor), (YAW, yaw))
            )
            return [azimuth % 360.0, float(s.state.angle_rates[rotor]) * 30.0 / np.pi, heading]

        columns = ("Azimuth_[deg]", "RotSpeed_[rpm]", "NacYaw_[deg]")
        return Channels(openfast=[Channel(columns, values)])

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """A box, and a spinner that is as large as the blade roots need."""
        blade, numbers = turbine.rotor.blade, turbine.numbers
        root = 0.5 * max(blade.chord_at(0.0), blade.thickness_at(0.0))
        size = float(np.hypot(blade.hub_radius, root))  # the roots are inside
        nacelle, hub = turbine.part(NACELLE), turbine.part(HUB)
        distance = turbine.case.turbine.hub_distance
        return [
            nacelle_surface(nacelle, distance, size, numbers[NACELLE]),
            hub_surface(hub, size, numbers[HUB]),
        ]
