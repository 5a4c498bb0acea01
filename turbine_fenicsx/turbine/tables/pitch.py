"""The table of the pitch bearings: its keys, and what they have to do with each other."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

from pydantic import Field

from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import (
    AngularSpeed,
    Kilograms,
    Number,
    Radians,
    Seconds,
    TorsionalDamping,
    TorsionalStiffness,
)
from turbine_fenicsx.case.section import (
    Flag,
    Moment,
    NotNegative,
    Positive,
    Section,
    UnusedKeys,
)


class PitchCase(Section):
    """Pitch bearings: what turns the blades about their spans.

    The rigid turbine has pitch bearings always; in the hybrid turbine ``bearings`` puts a rigid
    ring between hub and root of each blade. All blades start at the pitch ``initial``. With the
    drive ``"prescribed"`` they turn from there by ``angle`` in ``duration``, smoothly, or follow
    the columns of a ``file`` of comma-separated values. With ``"actuator"`` they follow commands of
    the controller like an oscillator of ``frequency`` and ``damping_ratio``.
    """

    bearings: Flag = False
    """Whether the blades of the hybrid turbine turn in pitch bearings, see
    howto/turbine_options."""
    ring_mass: Annotated[Kilograms, Positive] = 1000.0
    """Mass of the ring between hub and root of each blade."""
    ring_euler: tuple[Moment, Moment, Moment] = (400.0, 20.0, 400.0)
    """Principal values of the Euler tensor of a ring along chord, span and rotor axis."""
    drive: Literal["free", "spring", "prescribed", "actuator"] = "free"
    """Drive of the blades: none, spring and damper, a motion in time, or an actuator that follows
    commands, see howto/control."""
    initial: Annotated[Radians, Field(ge=-0.75 * pi, le=0.75 * pi)] = 0.0
    """Pitch at t = 0, positive to feather."""
    stiffness: Annotated[TorsionalStiffness, NotNegative] = 0.0
    """With ``drive = "spring"``: torsional spring on the pitch angle, from its initial value."""
    damping: Annotated[TorsionalDamping, NotNegative] = 0.0
    """With ``drive = "spring"``: damper on the rate of the pitch angle."""
    angle: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi)] = 0.0
    """With ``drive = "prescribed"``: how far the blades turn from ``initial`` on, positive to
    feather; 0 locks the bearings."""
    start: Annotated[Seconds, NotNegative] = 0.0
    """With ``drive = "prescribed"``: when the motion begins."""
    duration: Annotated[Seconds, Positive] = 5.0
    """With ``drive = "prescribed"``: how long it takes; velocity and acceleration stay
    continuous."""
    frequency: Annotated[AngularSpeed, Positive] = 6.0
    """With ``drive = "actuator"``: natural frequency of the drive."""
    damping_ratio: Annotated[Number, Positive] = 0.8
    """With ``drive = "actuator"``: its damping ratio."""
    file: Annotated[str | None, DataFile("pitch file")] = None
    """With ``drive = "prescribed"``: CSV file with ``time`` and ``pitch``, or ``pitch_1`` to
    ``pitch_3``, relative to the case file, see howto/tables."""


def has_bearings(pitch: PitchCase, model: str) -> bool:
    """Whether the blades can turn about their spans: always in the rigid turbine.

    Args:
        pitch: The table.
        model: The key ``turbine.model``.
    """
    return model == "rigid" or pitch.bearings


def check_pitch(pitch: PitchCase, model: str) -> str:
    """A sentence if a spring drive has neither spring nor damper, else nothing."""
    idle = pitch.drive != "spring" or not has_bearings(pitch, model)
    if idle or pitch.stiffness > 0.0 or pitch.damping > 0.0:
        return ""
    return 'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0'


def find_unused_pitch_keys(pitch: PitchCase, model: str) -> UnusedKeys:
    """Keys without effect, of the pitch torque as well."""
    if not has_bearings(pitch, model):
        others = set(type(pitch).model_fields) - {"bearings"}
        yield "pitch", tuple(others), "without pitch.bearings = true"
        yield "loads", ("pitch_torque",), "without pitch.bearings = true"
        return
    if model == "rigid":
        rings = ("bearings", "ring_mass", "ring_euler")
        yield "pitch", rings, 'with turbine.model = "rigid", which has pitch bearings always'
    drives = {
        "spring": ("stiffness", "damping"),
        "prescribed": ("angle", "start", "duration", "file"),
        "actuator": ("frequency", "damping_ratio"),
    }
    for drive, names in drives.items():
        if pitch.drive != drive:
            yield "pitch", names, f'with pitch.drive = "{pitch.drive}"'
    if pitch.drive in ("prescribed", "actuator"):
        yield "loads", ("pitch_torque",), f'with pitch.drive = "{pitch.drive}"'
    if pitch.drive == "prescribed":
        if pitch.file is not None:
            yield "pitch", ("angle", "start", "duration"), "beside pitch.file"
        elif pitch.angle == 0.0:
            yield "pitch", ("start", "duration"), "with pitch.angle = 0"
