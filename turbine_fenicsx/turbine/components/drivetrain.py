"""Shaft and generator: what turns behind the hub.

The generator turns on the slow side, with its moment of inertia times the square of the ratio. So
it has the right energy and takes the right torque to speed up. Its angular momentum about the shaft
is the ratio times that of the fast shaft, as in a gearbox whose shafts turn in one sense.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.forces.joint_damper import JointDamper
from turbine_fenicsx.forces.joint_spring import JointSpring
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.joints.rigid import Rigid
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.records.conventions import HUB
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.surfaces import tube
from turbine_fenicsx.turbine.components.component import Assembly, Component, Turbine
from turbine_fenicsx.turbine.components.nacelle import ROTOR

GENERATOR, SHAFT = "generator_rotor", "shaft"
"""Names of the body that turns with the generator, and of its joint with the hub."""

DRUM = 0.35
"""Radius and half of the length of the drum in pictures, as part of the distance to the hub."""


@dataclass(frozen=True)
class Drivetrain(Component):
    """A generator that turns with the hub, or at the end of a shaft that twists."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Body `GENERATOR`, joint `SHAFT` with spring and damper, friction of the bearing."""
        d, layout, hub = assembly.case.drivetrain, assembly.rotor.layout, assembly.part(HUB)
        found: list[Any] = []
        if d.friction > 0.0:
            found.append(JointDamper("friction of the main bearing", ROTOR, d.friction))
        if d.model == "none":
            return found
        inertia, place = d.ratio**2 * d.generator_inertia, _find_place(layout)
        disc = (0.5 * inertia, 0.5 * inertia, 0.0)
        generator = RigidBody(GENERATOR, d.mass, disc, position=place, directors=layout.axes.T)
        if d.model == "stiff":
            return [*found, generator, Rigid(SHAFT, hub, generator, place)]
        _, up, shaft = layout.axes
        found += [
            generator,
            Revolute(SHAFT, hub, generator, point=place, axis=shaft, reference=up),
            JointSpring("torsion of the shaft", SHAFT, d.stiffness),
        ]
        if d.damping > 0.0:
            found.append(JointDamper("damping of the shaft", SHAFT, d.damping))
        return found

    def surfaces(self, turbine: Turbine) -> list[RigidSurface]:
        """A drum around the shaft."""
        if turbine.find(GENERATOR) is None:
            return []
        layout, body = turbine.rotor.layout, turbine.part(GENERATOR)
        size = DRUM * float(np.linalg.norm(_find_place(layout) - layout.centre))
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)[:, None]
        side, up, shaft = layout.axes
        circle = size * (np.cos(angle) * side + np.sin(angle) * up)
        drum = np.array(
            [np.asarray(body.position) + circle + z * size * shaft for z in (-1.0, 1.0)]
        )
        return [RigidSurface(body, *tube(drum), turbine.numbers[GENERATOR])]


def fast_shaft(system: MultibodySystem, ratio: float) -> dict[str, float]:
    """Factors of the joint coordinates in the angle of the generator against the nacelle."""
    names = [ROTOR, *((SHAFT,) if SHAFT in system.joint_coordinate_names else ())]
    return dict.fromkeys(names, ratio)


def _find_place(layout: RotorLayout) -> Array:
    """The point of the shaft above the yaw axis, shape (3,) [m]."""
    centre, shaft = np.asarray(layout.centre, dtype=float), layout.axes[2]
    return np.asarray(centre - centre[2] / shaft[2] * shaft)
