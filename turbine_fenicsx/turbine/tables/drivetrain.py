"""The tables of drivetrain and yaw bearing: their keys, and which of them need each other."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from turbine_fenicsx.case.quantities import (
    EulerMoment,
    Kilograms,
    Number,
    Torque,
    TorsionalDamping,
    TorsionalStiffness,
)
from turbine_fenicsx.case.section import NotNegative, Positive, Section


class DrivetrainCase(Section):
    """Shaft, gearbox and generator.

    With ``"stiff"`` the generator turns with the hub, with ``"two_mass"`` at the end of a shaft
    that twists; without a drivetrain it has no inertia. ``generator_inertia`` counts on the fast
    shaft, ``stiffness``, ``damping``, ``friction`` and ``brake_torque`` on the slow one.
    ``efficiency`` is that of the conversion to electrical power.
    """

    model: Literal["none", "stiff", "two_mass"] = "none"
    """Generator without inertia, turning with the hub, or at the end of a shaft that twists, see
    howto/control."""
    ratio: Annotated[Number, Positive] = 1.0
    """Turns of the generator for one turn of the rotor."""
    generator_inertia: Annotated[EulerMoment, NotNegative] = 0.0
    """Moment of inertia of what turns fast, about the fast shaft."""
    mass: Annotated[Kilograms, Positive] = 1000.0
    """Mass of the body that turns with the generator, on the shaft above the yaw axis."""
    stiffness: Annotated[TorsionalStiffness, NotNegative] = 0.0
    """Torsional stiffness of the slow shaft."""
    damping: Annotated[TorsionalDamping, NotNegative] = 0.0
    """Damping of its torsion."""
    friction: Annotated[TorsionalDamping, NotNegative] = 0.0
    """Viscous friction of the main bearing, torque by speed of the rotor."""
    efficiency: Annotated[Number, Field(gt=0.0, le=1.0)] = 1.0
    """Electrical power by mechanical power of the generator."""
    brake_torque: Annotated[Torque, NotNegative] = 0.0
    """Torque of the closed brake, on the slow shaft."""


class YawCase(Section):
    """Yaw bearing: free, locked, or turned at the rate that the controller commands."""

    drive: Literal["free", "lock", "drive"] = "free"
    """Yaw bearing: turns freely, is locked, or turns at the rate that the controller commands."""
