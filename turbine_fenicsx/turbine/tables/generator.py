"""The table of a generator without a controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from turbine_fenicsx.case.quantities import Torque
from turbine_fenicsx.case.section import Finite, Section, UnusedKeys
from turbine_fenicsx.foundation.text_files import quote

if TYPE_CHECKING:
    from turbine_fenicsx.turbine.tables.wind import WindCase


class GeneratorCase(Section):
    """Generator between rotor and nacelle, without a controller.

    It keeps the rotor at ``turbine.rotor_speed``, whatever torque that takes, or brakes it with a
    constant ``torque``; without one, with the mean torque of the wind on a rotor of stiff blades.
    """

    keeps: Literal["nothing", "speed", "torque"] = "nothing"
    """Quantity that a generator without a controller keeps: nothing, ``turbine.rotor_speed``, or
    its torque."""
    torque: Annotated[Torque, Finite] | None = None
    """With ``keeps = "torque"``: torque against the rotation; none: the mean torque of the wind on
    stiff blades."""


def check_generator(
    generator: GeneratorCase, wind: WindCase, rotor_speed: float, control: str
) -> str:
    """A sentence if a controller has another generator, or the torque is not known; else nothing.

    Args:
        generator: The table.
        wind: The table of the wind, whose torque is that of the generator.
        rotor_speed: The key ``turbine.rotor_speed``.
        control: The key ``control.kind``.
    """
    if generator.keeps != "nothing" and control != "none":
        return (
            f'generator.keeps = "{generator.keeps}": expected "nothing" beside control.kind = '
            f"{quote(control)}, whose generator it would be"
        )
    if generator.keeps != "torque" or generator.torque is not None:
        return ""
    if wind.speed and rotor_speed > 0.0:
        return ""
    return (
        'generator.keeps = "torque": expected generator.torque, or wind.speed and '
        "turbine.rotor_speed greater than 0, from which it follows"
    )


def find_unused_generator_keys(generator: GeneratorCase) -> UnusedKeys:
    """Keys without effect."""
    if generator.keeps != "torque":
        yield "generator", ("torque",), f'with generator.keeps = "{generator.keeps}"'
