"""Nacelle and hub, and the yaw and rotor bearings (section 2 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.control.drives import YawDrive
from turbine_fenicsx.foundation.rotations import E2, E3
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.records.conventions import HUB, NACELLE, OPENFAST_SIGNS
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.blades.rotor_plan import AZIMUTHS
from turbine_fenicsx.turbine.blades.surfaces import hub_surface, nacelle_surface
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.tables.rigid_parts import Inertia

YAW, ROTOR = "yaw", "rotor"
"""Names of the bearings and of their angles."""

SUPPORT = "tower_top"
"""Rigid body that carries the yaw bearing if it stands already; else the ground carries it."""


@dataclass(frozen=True)
class Nacelle(Component):
    """Nacelle, hub, and the yaw and rotor bearings, eqs (27), (28)."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Bodies ``nacelle`` and ``hub``, joints ``yaw`` and ``rotor``; see `SUPPORT`."""
        p, layout = assembly.case.turbine.parameters(), assembly.rotor.layout
        _, up, shaft = layout.axes
        nacelle = _make_body(NACELLE, p.nacelle, np.zeros(3), np.eye(3))
        hub = _make_body(HUB, p.hub, layout.centre, layout.axes)
        support = assembly.find(SUPPORT)
        yaw = Revolute(YAW, support, nacelle, point=(0.0, 0.0, 0.0), axis=-E2, reference=E3)
        rotor = Revolute(ROTOR, nacelle, hub, point=layout.centre, axis=shaft, reference=up)
        return [nacelle, hub, yaw, rotor]

    def channels(self, turbine: Turbine) -> Channels:
        """Azimuth [0, 360), rotor speed and yaw for OpenFAST's readers.

        The azimuth is that of blade 1, 0 where it points up. Azimuth and speed count positive about
        the shaft, downwind; the nacelle's yaw about the upward vertical, opposite to the paper's.
        """
        coordinates = turbine.system.joint_coordinate_names
        rotor, yaw = coordinates.index(ROTOR), coordinates.index(YAW)

        def values(s: Snapshot) -> list[float]:
            azimuth, heading = (
                float(OPENFAST_SIGNS[name] * s.state.joint_coordinates[k])
                for name, k in ((ROTOR, rotor), (YAW, yaw))
            )
            azimuth = (azimuth + AZIMUTHS[0]) % (2.0 * np.pi)
            return [azimuth, float(s.state.joint_rates[rotor]), heading]

        return Channels(openfast=[in_openfast(("Azimuth", "RotSpeed", "NacYaw"), values)])

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """A box, and a spinner that is as large as the blade roots need."""
        blades, numbers = turbine.rotor.blades, turbine.numbers
        size = float(np.hypot(blades.hub_radius, blades.root_radius))  # the roots are inside
        nacelle, hub, layout = turbine.part(NACELLE), turbine.part(HUB), turbine.rotor.layout
        return [
            nacelle_surface(nacelle, layout, size, numbers[NACELLE]),
            hub_surface(hub, layout, size, numbers[HUB]),
        ]


@dataclass(frozen=True)
class Yaw(Component):
    """A drive of the yaw bearing, which stands still unless it is commanded."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """A prescribed motion of the angle ``yaw``."""
        return [PrescribedMotion(YAW, YawDrive(OPENFAST_SIGNS[YAW]))]


def _make_body(name: str, inertia: Inertia, origin: npt.ArrayLike, axes: Array) -> RigidBody:
    """A rigid part.

    Args:
        origin: From where the centre of mass counts, shape (3,) [m].
        axes: Axes of centre and inertia as rows, shape (3, 3).
    """
    position = np.asarray(origin) + inertia.centre @ axes
    if inertia.tensor is None:
        return RigidBody(name, inertia.mass, inertia.euler, position=position, directors=axes.T)
    return RigidBody.from_inertia(
        name, inertia.mass, inertia.tensor, position=position, axes=axes.T
    )
