"""The table of a generator without a controller."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Torque
from turbine_fenicsx.case.rules import Only
from turbine_fenicsx.case.section import Finite, Section
from turbine_fenicsx.foundation.text_files import quote


class GeneratorCase(Section):
    """Generator between rotor and nacelle, without a controller.

    It keeps the rotor at ``turbine.rotor_speed``, whatever torque that takes, or brakes it with a
    constant ``torque``; without one, with the mean torque of the wind on a rotor of stiff blades.
    """

    keeps: Literal["nothing", "speed", "torque"] = "nothing"
    """Quantity that a generator without a controller keeps: nothing, ``turbine.rotor_speed``, or
    its torque."""
    torque: Annotated[Annotated[Torque, Finite] | None, Only("keeps", "torque")] = None
    """With ``keeps = "torque"``: torque against the rotation; none: the mean torque of the wind on
    stiff blades."""

    @check("", "wind", "turbine.rotor_speed", "control")
    def _check_torque(self, case: Any) -> str:
        """There is one generator, and its torque is known."""
        kind = case.control.kind
        if self.keeps != "nothing" and kind != "none":
            return (
                f'generator.keeps = "{self.keeps}": expected "nothing" beside control.kind = '
                f"{quote(kind)}, whose generator it would be"
            )
        if self.keeps != "torque" or self.torque is not None:
            return ""
        if case.wind.speed and case.turbine.rotor_speed > 0.0:
            return ""
        return (
            'generator.keeps = "torque": expected generator.torque, or wind.speed and '
            "turbine.rotor_speed greater than 0, from which it follows"
        )
