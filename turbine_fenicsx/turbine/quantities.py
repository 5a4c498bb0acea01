"""Numbers with units in case files: ``"45 GPa"``, ``"12 s"``, or bare SI."""

from __future__ import annotations

import re
from functools import cache
from typing import Annotated, Any

from pydantic import BeforeValidator

_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\W\d][^;,]*)")


@cache
def _registry() -> Any:
    """The unit registry, made on first use because it is slow to import."""
    import pint

    return pint.UnitRegistry()


def to_si(value: Any, unit: str) -> Any:
    """A bare number as it is, a string with a unit in SI.

    Args:
        value: Number or string.
        unit: The SI unit that is expected, for example "Pa".

    Returns:
        The number in that unit; anything but strings unchanged.

    Raises:
        ValueError: for a string that is no quantity of this kind.
    """
    hint = f'give a number in {unit} or a string such as "1 {unit}"'
    if isinstance(value, bool):
        raise ValueError(hint)
    if not isinstance(value, str):
        return value
    try:
        return float(value)
    except ValueError:
        pass
    match = _NUMBER_AND_UNIT.fullmatch(value)
    try:
        assert match is not None
        return float(_registry().Quantity(float(match[1]), match[2]).to(unit).magnitude)
    except Exception:
        raise ValueError(hint) from None


def quantity(unit: str) -> Any:
    """Type of a number with the given SI unit, for pydantic models."""
    return Annotated[float, BeforeValidator(lambda value: to_si(value, unit))]


Seconds = quantity("s")
Metres = quantity("m")
Kilograms = quantity("kg")
EulerMoment = quantity("kg m^2")
Density = quantity("kg/m^3")
Pascal = quantity("Pa")
Torque = quantity("N m")
Acceleration = quantity("m/s^2")
