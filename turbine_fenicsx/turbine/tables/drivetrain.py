"""The tables of drivetrain and yaw bearing."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import (
    EulerMoment,
    Kilograms,
    Number,
    Torque,
    TorsionalDamping,
    TorsionalStiffness,
)
from turbine_fenicsx.case.rules import AnyOf, If, Only, Unless
from turbine_fenicsx.case.section import NotNegative, Positive, Section

_CONTROLLED = Unless("control.kind", "none")


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
    ratio: Annotated[Number, Positive, AnyOf(_CONTROLLED, Unless("model", "none"))] = 1.0
    """Turns of the generator for one turn of the rotor."""
    generator_inertia: Annotated[EulerMoment, NotNegative, Unless("model", "none")] = 0.0
    """Moment of inertia of what turns fast, about the fast shaft."""
    mass: Annotated[Kilograms, Positive, Unless("model", "none")] = 1000.0
    """Mass of the body that turns with the generator, on the shaft above the yaw axis."""
    stiffness: Annotated[TorsionalStiffness, NotNegative, Only("model", "two_mass")] = 0.0
    """Torsional stiffness of the slow shaft."""
    damping: Annotated[TorsionalDamping, NotNegative, Only("model", "two_mass")] = 0.0
    """Damping of its torsion."""
    friction: Annotated[TorsionalDamping, NotNegative] = 0.0
    """Viscous friction of the main bearing, torque by speed of the rotor."""
    efficiency: Annotated[Number, Field(gt=0.0, le=1.0), _CONTROLLED] = 1.0
    """Electrical power by mechanical power of the generator."""
    brake_torque: Annotated[
        Torque,
        NotNegative,
        If(lambda case: case.may_brake, say='without an event of kind "brake"'),
    ] = 0.0
    """Torque of the closed brake, on the slow shaft."""

    @check("")
    def _check_shaft(self, case: Any) -> str:
        """The generator has an inertia, a shaft that twists a stiffness."""
        model = f'with drivetrain.model = "{self.model}"'
        if self.model != "none" and not self.generator_inertia > 0.0:
            return f"drivetrain.generator_inertia = 0: expected more than 0 {model}"
        if self.model == "two_mass" and not self.stiffness > 0.0:
            return f"drivetrain.stiffness = 0: expected more than 0 {model}"
        return ""


class YawCase(Section):
    """Yaw bearing: free, locked, or turned at the rate that the controller commands."""

    drive: Literal["free", "lock", "drive"] = "free"
    """Yaw bearing: turns freely, is locked, or turns at the rate that the controller commands."""
