"""The tables of the controller."""

from __future__ import annotations

import os
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import (
    AngularSpeed,
    Number,
    Power,
    Radians,
    Seconds,
    Torque,
    TorqueGain,
    TorqueRate,
)
from turbine_fenicsx.case.rules import Only
from turbine_fenicsx.case.section import NotNegative, Positive, Section
from turbine_fenicsx.control.discon import check_library
from turbine_fenicsx.control.pi import PitchLaw
from turbine_fenicsx.control.torque_law import TorqueLaw
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible

PYTHON = "python:"

_TORQUE, _PITCH = TorqueLaw(), PitchLaw()


class TorqueLawCase(Section):
    """Torque over the speed of the generator, of ``control.kind = "pi"``.

    There is none below ``cut_in_speed``, ``gain`` times speed squared from ``optimal_speed`` on,
    and constant power from ``rated_speed`` on; straight lines are between these regions, the second
    with a ``slip``. The defaults are those of ``turbine.file``; without one, of the NREL 5 MW
    turbine.
    """

    cut_in_speed: Annotated[AngularSpeed, Positive] = _TORQUE.cut_in_speed
    """Generator speed below which there is no torque."""
    optimal_speed: Annotated[AngularSpeed, Positive] = _TORQUE.optimal_speed
    """Generator speed at which region 2 begins."""
    gain: Annotated[TorqueGain, Positive] = _TORQUE.gain
    """Torque by generator speed squared in region 2."""
    rated_speed: Annotated[AngularSpeed, Positive] = _TORQUE.rated_speed
    """Generator speed from which on power is constant."""
    rated_power: Annotated[Power, Positive, Plausible(1e3, 1e8)] = _TORQUE.rated_power
    """Mechanical power of the generator above rated speed."""
    slip: Annotated[Number, Positive] = _TORQUE.slip
    """Torque of region 2 1/2 rises from rated speed/(1 + slip) on."""
    largest: Annotated[Torque, Positive] = _TORQUE.largest
    """Largest torque."""
    rate: Annotated[TorqueRate, Positive] = 15000.0
    """Largest change of torque in time."""

    def make(self) -> TorqueLaw:
        """The law; raises ModelError where its regions do not follow each other."""
        return TorqueLaw(**self.model_dump(exclude={"rate"}))


Angle = Annotated[Radians, Field(ge=-pi, le=pi)]


class PitchLawCase(Section):
    """PI law of the pitch, of ``control.kind = "pi"``; defaults as for the torque.

    The pitch keeps the generator at ``speed``. Gains fall with the pitch and are half at
    ``gain_angle``; from ``rated_margin`` above the ``fine`` pitch on power is kept constant.
    """

    speed: Annotated[AngularSpeed, Positive] = _PITCH.speed
    """Generator speed that the pitch keeps."""
    proportional_gain: Annotated[Seconds, NotNegative] = _PITCH.proportional_gain
    """K_P at the fine pitch, pitch by speed."""
    integral_gain: Annotated[Number, Positive] = _PITCH.integral_gain
    """K_I at the fine pitch, pitch by angle."""
    gain_angle: Annotated[Radians, Positive] = _PITCH.gain_angle
    """Pitch above the fine one at which gains are half."""
    fine: Angle = _PITCH.fine
    """Smallest pitch, that below rated power."""
    largest: Angle = _PITCH.largest
    """Largest pitch."""
    rate: Annotated[AngularSpeed, Positive, Plausible(0.1 * DEGREE, 60.0 * DEGREE)] = _PITCH.rate
    """Largest change of pitch in time."""
    rated_margin: Annotated[Radians, NotNegative] = _PITCH.rated_margin
    """Pitch above the fine one from which on power is kept constant whatever the speed."""

    def make(self) -> PitchLaw:
        """The law; raises ModelError for limits that leave no pitch."""
        return PitchLaw(**self.model_dump())


def is_controller(kind: str) -> bool:
    """Whether a key ``control.kind`` names a controller, right or wrong in its detail."""
    return kind in ("pi", "discon") or kind.startswith(PYTHON)


def _check_kind(kind: str) -> str:
    """One of the kinds; the file of a Python controller becomes absolute."""
    if kind in ("none", "pi", "discon"):
        return kind
    file, _, name = kind.removeprefix(PYTHON).rpartition(":")
    if not kind.startswith(PYTHON) or not file or not name.isidentifier():
        raise ValueError('expected "none", "pi", "discon" or "python:FILE:CLASS"')
    return f"{PYTHON}{os.path.abspath(file)}:{name}"


File = Annotated[str, AfterValidator(os.path.abspath)]


class ControllerFile(DataFile):
    """Marks the kind of a controller, which names a file if it is one in Python."""

    def change(self, value: str, change: Callable[[str], str]) -> str:
        """The kind with another name of the file."""
        if not value.startswith(PYTHON):
            return value
        file, _, name = value.removeprefix(PYTHON).rpartition(":")
        return f"{PYTHON}{change(file)}:{name}"


_PI, _DISCON = Only("kind", "pi"), Only("kind", "discon")


class ControlCase(Section):
    """Controller: what it is, and where it comes from.

    It commands generator torque and pitch, and is asked after each step. ``"pi"`` is built in and
    takes its values from the tables below. ``"discon"`` is a ``library`` in Bladed's shape with its
    ``input`` file, such as ROSCO; ``"python:FILE:CLASS"`` a class in a file of yours. Libraries and
    Python files are run with your rights.
    """

    kind: Annotated[str, AfterValidator(_check_kind), ControllerFile("controller")] = "none"
    """Controller: ``"none"``, ``"pi"``, ``"discon"`` or ``"python:FILE:CLASS"``, see
    howto/control."""
    library: Annotated[File | None, DataFile("library of the controller"), _DISCON] = None
    """Shared library with the routine DISCON, relative to the case file."""
    input: Annotated[File | None, DataFile("DISCON.IN"), _DISCON] = None
    """Input file of the library, often called DISCON.IN, relative to the case file."""
    filter_frequency: Annotated[AngularSpeed, Positive, _PI] = 1.570796
    """Corner of the low pass of the generator speed."""
    torque: Annotated[TorqueLawCase, _PI] = TorqueLawCase()
    pitch: Annotated[PitchLawCase, _PI] = PitchLawCase()

    @property
    def python_class(self) -> tuple[Path, str] | None:
        """File and class of a Python controller; None for others."""
        if not self.kind.startswith(PYTHON):
            return None
        file, _, name = self.kind.removeprefix(PYTHON).rpartition(":")
        return Path(file), name

    @property
    def is_foreign(self) -> bool:
        """Whether it comes from outside of the package."""
        return self.kind == "discon" or self.python_class is not None

    @check("", "pitch.drive", "pitch.bearings", "turbine.model")
    def _check_needs(self, case: Any) -> str:
        """The controller is there and has something to act on."""
        if self.kind == "none":
            return ""
        key = f'control.kind = "{self.kind}"'
        if not case.has_pitch_bearings:
            return f"{key}: expected pitch.bearings = true, a controller turns the blades"
        if case.pitch.drive != "actuator":
            return f'{key}: expected pitch.drive = "actuator", got "{case.pitch.drive}"'
        if self.kind == "discon":
            for name in ("library", "input"):
                if getattr(self, name) is None:
                    return f"{key}: expected control.{name}, the name of a file"
            assert self.library and self.input
            return check_library(Path(self.library), Path(self.input))
        if self.python_class and not self.python_class[0].is_file():
            return f"{key}: there is no file '{self.python_class[0]}'"
        return ""

    @check("torque")
    def _check_torque(self, case: Any) -> str:
        """Regions of the torque follow each other."""
        return self._check_law("torque")

    @check("pitch")
    def _check_pitch(self, case: Any) -> str:
        """Limits of the pitch leave some."""
        return self._check_law("pitch")

    def _check_law(self, name: str) -> str:
        """Complaint about a law."""
        if self.kind != "pi":
            return ""
        try:
            getattr(self, name).make()
        except ModelError as error:
            return f"control.{name}: {error}"
        return ""
