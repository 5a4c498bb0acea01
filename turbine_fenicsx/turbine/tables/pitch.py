"""The table of the pitch bearings, and the file of their angles over the time."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, pi
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, ValidatorFunctionWrapHandler, WrapValidator

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile, read_if_changed
from turbine_fenicsx.case.quantities import (
    AngularSpeed,
    Kilograms,
    Number,
    Radians,
    Seconds,
    TorsionalDamping,
    TorsionalStiffness,
    Unit,
)
from turbine_fenicsx.case.rules import AnyOf, Beside, Only, Unless
from turbine_fenicsx.case.schema import Also
from turbine_fenicsx.case.section import Flag, Moment, NotNegative, Positive, Section
from turbine_fenicsx.case.time_table import Column, TimeTable, read_time_table
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible

BLADES = ("pitch_1", "pitch_2", "pitch_3")
"""Columns for each blade by itself, in place of one for all."""

MAX_ANGLE = 2.0 * pi
"""Pitch [rad]."""

_PITCH = Plausible(0.0, 110.0 * DEGREE)

START_TOLERANCE = 1e-6
"""Pitch at t = 0 and that at which the blades start agree so well [rad]."""

HAS_BEARINGS = AnyOf(Only("pitch.bearings", True), Only("turbine.model", "rigid"))
"""Rule of keys that count with pitch bearings only, which the rigid turbine has always."""

_RINGS = Only(
    "turbine.model",
    "hybrid",
    say='with turbine.model = "rigid", which has pitch bearings always',
)
_MOTION = (Only("drive", "prescribed"), Beside("file"))
_COLUMNS = {name: Column("rad", -MAX_ANGLE, MAX_ANGLE) for name in ("pitch", *BLADES)}


def _take_one_for_all(value: Any, check: ValidatorFunctionWrapHandler) -> Any:
    """Three angles, or one that all blades have."""
    if isinstance(value, list | tuple):
        return check(value)
    try:
        return check((value,) * len(BLADES))
    except ValidationError as error:
        raise ValueError(error.errors()[0]["msg"].removeprefix("Value error, ")) from None


_Angle = Annotated[Radians, Field(ge=-0.75 * pi, le=0.75 * pi)]


@read_if_changed("table")
def _load_angles(path: str) -> TimeTable:
    """Pitch of a file; raises InputError."""
    return read_time_table(path, _COLUMNS)


def load_pitch(path: str) -> list[tuple[TimeTable, str]]:
    """The table with the pitch of each blade, and its column.

    Raises:
        InputError: if it cannot be read, or does not have the pitch of all blades once.
    """
    table = _load_angles(path)
    found = set(table.columns)
    if found == {"pitch"}:
        return [(table, "pitch")] * len(BLADES)
    if found == set(BLADES):
        return [(table, name) for name in BLADES]
    raise InputError(
        f"{table.name} has the columns {', '.join(table.columns)}, expected pitch, or "
        f"{', '.join(BLADES[:-1])} and {BLADES[-1]}"
    )


class PitchCase(Section):
    """Pitch bearings: what turns the blades about their spans.

    The rigid turbine has pitch bearings always; in the hybrid turbine ``bearings`` puts a rigid
    ring between hub and root of each blade. Blades start at the pitch ``initial``. With the
    drive ``"prescribed"`` they turn from there by ``angle`` in ``duration``, smoothly, or follow
    the columns of a ``file`` of comma-separated values. With ``"actuator"`` they follow commands of
    the controller like an oscillator of ``frequency`` and ``damping_ratio``.
    """

    rules = (HAS_BEARINGS,)

    bearings: Annotated[Flag, _RINGS] = False
    """Whether the blades of the hybrid turbine turn in pitch bearings, see
    howto/turbine_options."""
    ring_mass: Annotated[Kilograms, Positive, _RINGS, Plausible(1.0, 2e5)] = 1000.0
    """Mass of the ring between hub and root of each blade."""
    ring_euler: Annotated[tuple[Moment, Moment, Moment], _RINGS] = (400.0, 20.0, 400.0)
    """Principal values of the Euler tensor of a ring along chord, span and rotor axis."""
    drive: Literal["free", "lock", "spring", "prescribed", "actuator"] = "free"
    """Drive of the blades: none, a lock, spring and damper, a motion in time, or an actuator that
    follows commands, see howto/control."""
    initial: Annotated[
        tuple[_Angle, _Angle, _Angle],
        WrapValidator(_take_one_for_all),
        Also("number", "string"),
        Unit("rad"),
        _PITCH,
    ] = (0.0, 0.0, 0.0)
    """Pitch at t = 0, positive to feather: one for all blades, or a list of three."""
    stiffness: Annotated[TorsionalStiffness, NotNegative, Only("drive", "spring")] = 0.0
    """With ``drive = "spring"``: torsional spring on the pitch angle, from its initial value."""
    damping: Annotated[TorsionalDamping, NotNegative, Only("drive", "spring")] = 0.0
    """With ``drive = "spring"``: damper on the rate of the pitch angle."""
    angle: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi), *_MOTION, _PITCH] = 0.0
    """With ``drive = "prescribed"``: how far the blades turn from ``initial`` on, positive to
    feather."""
    start: Annotated[Seconds, NotNegative, *_MOTION, Unless("angle", 0.0)] = 0.0
    """With ``drive = "prescribed"``: when the motion begins."""
    duration: Annotated[Seconds, Positive, *_MOTION, Unless("angle", 0.0)] = 5.0
    """With ``drive = "prescribed"``: how long it takes; velocity and acceleration stay
    continuous."""
    frequency: Annotated[AngularSpeed, Positive, Only("drive", "actuator")] = 6.0
    """With ``drive = "actuator"``: natural frequency of the drive."""
    damping_ratio: Annotated[Number, Positive, Only("drive", "actuator")] = 0.8
    """With ``drive = "actuator"``: its damping ratio."""
    file: Annotated[str | None, DataFile("pitch file"), Only("drive", "prescribed")] = None
    """With ``drive = "prescribed"``: CSV file with ``time`` and ``pitch``, or ``pitch_1`` to
    ``pitch_3``, relative to the case file, see howto/tables."""

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Blades start at rest in their bearings."""
        if self.file is None or self.drive != "prescribed" or not case.has_pitch_bearings:
            return
        for table, name in dict.fromkeys(load_pitch(self.file)):
            times, angles = table.times, table.columns[name]
            k = int(np.searchsorted(times, 0.0, side="right"))
            if 0 < k < len(times) and angles[k] != angles[k - 1]:
                rate = degrees((angles[k] - angles[k - 1]) / (times[k] - times[k - 1]))
                yield (
                    f"pitch.file: {name} begins with {rate:.3g} deg/s, but blades start at rest: "
                    "let it begin with two equal lines, or velocities alternate from step to step"
                )

    @check("drive", "stiffness", "damping")
    def _check_spring(self, case: Any) -> str:
        """A spring drive has a spring or a damper."""
        idle = self.drive != "spring" or not case.has_pitch_bearings
        if idle or self.stiffness > 0.0 or self.damping > 0.0:
            return ""
        return 'pitch.drive = "spring": expected pitch.stiffness or pitch.damping greater than 0'

    @check("file", "", "time.end", "turbine.model")
    def _check_file(self, case: Any) -> str:
        """The pitch can be read, lasts as long as the run, and begins where the blades start."""
        if self.file is None or self.drive != "prescribed" or not case.has_pitch_bearings:
            return ""
        try:
            blades = load_pitch(self.file)
        except InputError as error:
            return f"pitch.file: {error}"
        gap = blades[0][0].describe_gap(case.time.end)
        if gap:
            return f"pitch.file: {gap}"
        from turbine_fenicsx.forces.time_functions import Table  # not needed to read other cases

        for (table, name), initial in zip(blades, self.initial, strict=True):
            first = Table(table.times.tolist(), table.columns[name].tolist())(0.0)
            if abs(first - initial) > START_TOLERANCE:
                return (
                    f"pitch.initial = {degrees(initial):g} deg: expected {degrees(first):g} "
                    f"deg, the value of {name} at t = 0 in pitch.file"
                )
        return ""
