"""Pitch: the bearings that turn the blades about their spans, and what drives them.

The rigid turbine has its bearings between hub and blades. In the hybrid turbine a rigid ring at the
root of each blade turns on the hub, where the case asks for it.

The pitch angles that users give count like OpenFAST's: positive to feather, which is about the
span from tip to root. The coordinates of the bearings count like the paper's (`PITCH_SIGNS`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces import JointDamper, JointSpring, JointTorque
from turbine_fenicsx.forces.time_functions import Hat, Ramp
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.joints import PrescribedMotion, Revolute
from turbine_fenicsx.postprocessing.conventions import BLADES, HUB, OPENFAST_SIGNS
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.pitch import PitchCase, check_pitch
from turbine_fenicsx.turbine.case.tables import LoadsCase
from turbine_fenicsx.turbine.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.rotor_plan import AZIMUTHS, PITCH_SIGNS

BEARINGS = ("pitch_1", "pitch_2", "pitch_3")
"""Names of the bearings and of their angles."""

RINGS = ("ring_1", "ring_2", "ring_3")
"""Names of the rings between hub and flexible blades."""


@dataclass(frozen=True)
class Pitch(Component):
    """Pitch bearings, their rings, torques and drives; nothing where the blades are fixed."""

    def mistakes(self, case: Case) -> list[str]:
        """A spring drive without spring and damper."""
        sentence = check_pitch(case.pitch, case.turbine.model)
        return [sentence] if sentence else []

    def parts(self, assembly: Assembly) -> list[Any]:
        """Joints ``pitch_1`` ... between the hub and the rigid blades, or rings ``ring_1`` ..."""
        case, hub = assembly.case, assembly.part(HUB)
        if not case.has_pitch_bearings:
            return []
        if case.turbine.model == "rigid":
            turned = [assembly.part(name) for name in BLADES]
            bearings = _bearings(hub, turned, [hub.position] * len(turned))
        else:
            turned = _rings(hub, case.pitch, case.blade.hub_radius)
            bearings = _bearings(hub, turned, [ring.position for ring in turned])
        new = [body for body in turned if body not in assembly.parts]
        return [*new, *bearings, *pitch_torques(case.loads), *pitch_drive(case.pitch)]

    def channels(self, turbine: Turbine) -> Channels:
        """``BldPitch1`` ..., positive to feather; 0 without pitch bearings."""
        names = turbine.system.angle_names
        found = [(names.index(name), OPENFAST_SIGNS[name]) for name in BEARINGS if name in names]

        def values(s: Snapshot) -> list[float]:
            angles = [sign * float(np.degrees(s.state.angles[k])) for k, sign in found]
            return angles or [0.0] * len(BEARINGS)

        columns = tuple(f"BldPitch{k}_[deg]" for k in range(1, len(BEARINGS) + 1))
        return Channels(openfast=[Channel(columns, values)])


def _rings(hub: RigidBody, pitch: PitchCase, radius: float) -> list[RigidBody]:
    """Rings centred on the pitch axes, their axes along chord, span and rotor axis.

    Args:
        hub: The hub.
        pitch: Their mass and Euler values.
        radius: Distance of their centres from the hub centre [m].
    """
    turns, centre = [rotation_about(E3, azimuth) for azimuth in AZIMUTHS], np.asarray(hub.position)
    return [
        RigidBody(name, pitch.ring_mass, pitch.ring_euler, centre + radius * (R @ E2), R)
        for name, R in zip(RINGS, turns, strict=True)
    ]


def _bearings(hub: RigidBody, turned: list[RigidBody], points: list[Any]) -> Iterator[Revolute]:
    """Bearings of what turns on the hub about the spans of the blades, in the paper's signs."""
    for name, body, point, azimuth, sign in zip(
        BEARINGS, turned, points, AZIMUTHS, PITCH_SIGNS, strict=True
    ):
        span = rotation_about(E3, azimuth) @ E2
        yield Revolute(name, hub, body, point=point, axis=sign * span, reference=E3)


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
    hat = Hat(1.0, loads.duration)
    return [
        JointTorque(f"torque on {name}", name, -sign * loads.pitch_torque, hat)
        for name, sign in zip(BEARINGS, PITCH_SIGNS, strict=True)
    ]
