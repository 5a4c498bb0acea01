"""Pitch: the bearings that turn the blades about their spans, and what drives them.

The rigid turbine has its bearings between hub and blades. In the hybrid turbine a rigid ring at the
root of each blade turns on the hub, where the case asks for it.

The pitch angles that users give count like OpenFAST's: positive to feather, which is about the
span from tip to root. The coordinates of the bearings count like the paper's (`PITCH_SIGNS`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.control.drives import PitchDrive
from turbine_fenicsx.forces.joint_damper import JointDamper
from turbine_fenicsx.forces.joint_spring import JointSpring
from turbine_fenicsx.forces.joint_torque import JointTorque
from turbine_fenicsx.forces.time_functions import Constant, Ramp, Sum, Table
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.joints.revolute import Revolute
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.records.conventions import BLADES, HUB, OPENFAST_SIGNS
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.blades.rotor_plan import PITCH_SIGNS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.loads import make_hat, make_torque, read_torques
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.tables.pitch import PitchCase, load_pitch

BEARINGS = ("pitch_1", "pitch_2", "pitch_3")
"""Names of the bearings and of their angles."""

RINGS = ("ring_1", "ring_2", "ring_3")
"""Names of the rings between hub and flexible blades."""


@dataclass(frozen=True)
class Pitch(Component):
    """Pitch bearings, their rings, torques and drives; nothing where the blades are fixed."""

    def parts(self, assembly: Assembly) -> list[Any]:
        """Joints ``pitch_1`` ... between the hub and the rigid blades, or rings ``ring_1`` ..."""
        case, hub, rotor = assembly.case, assembly.part(HUB), assembly.rotor
        if not case.has_pitch_bearings:
            return []
        if case.turbine.model == "rigid":
            turned = [assembly.part(name) for name in BLADES]
            points: list[Any] = [rotor.layout.centre] * len(turned)
        else:
            turned = _make_rings(rotor.layout, case.pitch, rotor.blades.hub_radius)
            points = [ring.position for ring in turned]
        bearings = _make_bearings(hub, turned, points, rotor.layout)
        new = [body for body in turned if body not in assembly.parts]
        return [
            *new,
            *bearings,
            *make_pitch_torques(case, assembly.comm),
            *make_pitch_drive(case.pitch, assembly.comm),
        ]

    def channels(self, turbine: Turbine) -> Channels:
        """``BldPitch1`` ..., positive to feather; 0 without pitch bearings."""
        angles = find_angles(turbine)
        columns = [f"BldPitch{k}" for k in range(1, len(BEARINGS) + 1)]
        return Channels(openfast=[in_openfast(columns, lambda s: angles(s.state))])


def find_angles(turbine: Turbine) -> Callable[[State], list[float]]:
    """Function of the state with the pitch of all blades, 0 without bearings [rad]."""
    names = turbine.system.joint_coordinate_names
    found = [(names.index(name), OPENFAST_SIGNS[name]) for name in BEARINGS if name in names]

    def angles(state: State) -> list[float]:
        return [sign * float(state.joint_coordinates[k]) for k, sign in found] or [0.0] * len(
            BEARINGS
        )

    return angles


def _make_rings(layout: RotorLayout, pitch: PitchCase, radius: float) -> list[RigidBody]:
    """Rings centred on the pitch axes, their axes along chord, span and thickness of the blades.

    Args:
        radius: Distance of their centres from the rotor centre [m].
    """
    return [
        RigidBody(
            name,
            pitch.ring_mass,
            pitch.ring_euler,
            position=layout.point_on_span(k, radius),
            directors=layout.directors(k),
        )
        for k, name in enumerate(RINGS, start=1)
    ]


def _make_bearings(
    hub: RigidBody, turned: list[RigidBody], points: list[Any], layout: RotorLayout
) -> Iterator[Revolute]:
    """Bearings of what turns on the hub about the spans of the blades, in the paper's signs."""
    for k, (name, body, point, sign) in enumerate(
        zip(BEARINGS, turned, points, PITCH_SIGNS, strict=True), start=1
    ):
        span, _, normal = layout.frame(k)
        yield Revolute(name, hub, body, point=point, axis=sign * span, reference=normal)


def make_pitch_drive(pitch: PitchCase, comm: MPI.Intracomm = MPI.COMM_SELF) -> list[Any]:
    """Springs, dampers or prescribed motions of the pitch bearings. Collective.

    Args:
        comm: Whose rank 0 reads the file of the pitch, if there is one.
    """
    if pitch.drive == "prescribed" and pitch.file is not None:
        return _follow_table(pitch.file, comm)
    parts: list[Any] = []
    for name, initial in zip(BEARINGS, pitch.initial, strict=True):
        sign = OPENFAST_SIGNS[name]
        rest = sign * initial
        if pitch.drive == "lock":
            parts.append(PrescribedMotion(name, Constant(rest)))
        elif pitch.drive == "prescribed":
            turn = Ramp(sign * pitch.angle, pitch.duration, pitch.start, smooth=True)
            parts.append(PrescribedMotion(name, Sum(turn, Constant(rest)) if rest else turn))
        elif pitch.drive == "actuator":
            drive = PitchDrive(sign, pitch.frequency, pitch.damping_ratio, initial)
            parts.append(PrescribedMotion(name, drive))
        elif pitch.drive == "spring":
            if pitch.stiffness > 0.0:
                parts.append(JointSpring(f"spring of {name}", name, pitch.stiffness, rest))
            if pitch.damping > 0.0:
                parts.append(JointDamper(f"damper of {name}", name, pitch.damping))
    return parts


def _follow_table(file: str, comm: MPI.Intracomm) -> list[PrescribedMotion]:
    """Motions of the bearings as in a file. Collective."""
    blades = on_rank0(comm, lambda: load_pitch(file))
    return [
        PrescribedMotion(
            name,
            Table(table.times.tolist(), (OPENFAST_SIGNS[name] * table.columns[column]).tolist()),
        )
        for name, (table, column) in zip(BEARINGS, blades, strict=True)
    ]


def make_pitch_torques(case: Case, comm: MPI.Intracomm = MPI.COMM_SELF) -> list[JointTorque]:
    """Equal torques on all pitch bearings, positive to feather; none without one. Collective.

    Args:
        comm: Whose rank 0 reads the file of the torques, if there is one.
    """
    peak, table = case.loads.pitch_torque, read_torques(case, comm).get("pitch_torque")
    if peak == 0.0 and table is None:
        return []
    hat = make_hat(case.loads, case.time.ramp)
    return [
        make_torque(f"torque on {name}", name, -sign, peak, hat, table)
        for name, sign in zip(BEARINGS, PITCH_SIGNS, strict=True)
    ]
