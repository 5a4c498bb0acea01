"""Pitch: rings at the roots of flexible blades, their bearings, and what drives them.

The pitch angles that users give count like OpenFAST's: positive to feather, which is about the
span from tip to root. The coordinates of the bearings count like the paper's (`PITCH_SIGNS`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces import JointDamper, JointSpring, JointTorque
from turbine_fenicsx.forces.time_functions import Hat, Ramp
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.joints import PrescribedMotion, Revolute
from turbine_fenicsx.turbine.case.parameters import Inertia
from turbine_fenicsx.turbine.case.tables import LoadsCase, PitchCase
from turbine_fenicsx.turbine.rigid import AZIMUTHS, PITCH_SIGNS

BEARINGS = tuple(f"pitch_{k}" for k in range(1, len(PITCH_SIGNS) + 1))
"""Names of the pitch bearings and of their angles."""


@dataclass(frozen=True)
class RootRings:
    """Rigid rings between the hub and the roots of the blades.

    Args:
        inertia: Of one ring; axes along the chord, the span and the rotor axis.
        radius: Distance of the centre of a ring, which is on the pitch axis, from the hub centre
            [m].
    """

    inertia: Inertia
    radius: float

    def on(self, hub: RigidBody) -> tuple[list[RigidBody], list[Revolute]]:
        """The rings ``ring_1``, ... and their bearings ``pitch_1``, ... on a hub.

        Axes and signs are those of the rigid turbine.
        """
        rings, bearings = [], []
        for k, (azimuth, sign) in enumerate(zip(AZIMUTHS, PITCH_SIGNS, strict=True)):
            R = rotation_about(E3, azimuth)
            span = R @ E2
            centre = np.asarray(hub.position) + self.radius * span
            ring = RigidBody(f"ring_{k + 1}", self.inertia.mass, self.inertia.euler, centre, R)
            rings.append(ring)
            bearings.append(
                Revolute(BEARINGS[k], hub, ring, point=centre, axis=sign * span, reference=E3)
            )
        return rings, bearings


def pitch_drive(pitch: PitchCase) -> list[Any]:
    """Springs, dampers or prescribed motions of the pitch bearings.

    Args:
        pitch: Drive and its values.
    """
    if pitch.drive == "prescribed":
        return [
            PrescribedMotion(
                name, Ramp(-sign * pitch.angle, pitch.duration, pitch.start, smooth=True)
            )
            for name, sign in zip(BEARINGS, PITCH_SIGNS, strict=True)
        ]
    parts: list[Any] = []
    if pitch.drive == "spring":
        for name in BEARINGS:
            if pitch.stiffness > 0.0:
                parts.append(JointSpring(f"spring of {name}", name, pitch.stiffness))
            if pitch.damping > 0.0:
                parts.append(JointDamper(f"damper of {name}", name, pitch.damping))
    return parts


def pitch_torques(loads: LoadsCase) -> list[JointTorque]:
    """The same hat of torque on all pitch bearings, positive to feather; nothing for none."""
    if loads.pitch_torque == 0.0:
        return []
    return [
        JointTorque(name, Hat(-sign * loads.pitch_torque, loads.duration))
        for name, sign in zip(BEARINGS, PITCH_SIGNS, strict=True)
    ]
