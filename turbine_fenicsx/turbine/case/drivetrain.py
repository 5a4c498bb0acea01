"""The tables of drivetrain and yaw bearing: their keys, and which of them need each other."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from turbine_fenicsx.turbine.case.quantities import (
    EulerMoment,
    Kilograms,
    Number,
    Torque,
    TorsionalDamping,
    TorsionalStiffness,
)
from turbine_fenicsx.turbine.case.section import NotNegative, Positive, Section


class DrivetrainCase(Section):
    """Shaft, gearbox and generator.

    With ``"stiff"`` the generator turns with the hub, with ``"two_mass"`` at the end of a shaft
    that twists; without a drivetrain it has no inertia. ``generator_inertia`` counts on the fast
    shaft, ``stiffness``, ``damping``, ``friction`` and ``brake_torque`` on the slow one.
    ``efficiency`` is that of the conversion to electrical power.
    """

    model: Literal["none", "stiff", "two_mass"] = "none"
    ratio: Annotated[Number, Positive] = 1.0
    generator_inertia: Annotated[EulerMoment, NotNegative] = 0.0
    mass: Annotated[Kilograms, Positive] = 1000.0
    stiffness: Annotated[TorsionalStiffness, NotNegative] = 0.0
    damping: Annotated[TorsionalDamping, NotNegative] = 0.0
    friction: Annotated[TorsionalDamping, NotNegative] = 0.0
    efficiency: Annotated[Number, Field(gt=0.0, le=1.0)] = 1.0
    brake_torque: Annotated[Torque, NotNegative] = 0.0


class YawCase(Section):
    """Yaw bearing: free, locked, or turned at the rate that the controller commands."""

    drive: Literal["free", "lock", "drive"] = "free"
