"""Numbers with units in case files: ``"45 GPa"``, ``"12 s"``, or bare SI."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from math import isfinite, nan
from numbers import Real
from typing import Annotated, Any, get_args

from pydantic import BeforeValidator, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

Powers = tuple[int, ...]
"""Powers of metre, kilogram and second."""

_UNITS: dict[str, tuple[str, Powers]] = {
    "m": ("1", (1, 0, 0)),
    "g": ("1e-3", (0, 1, 0)),
    "t": ("1e3", (0, 1, 0)),
    "s": ("1", (0, 0, 1)),
    "min": ("60", (0, 0, 1)),
    "h": ("3600", (0, 0, 1)),
    "Hz": ("1", (0, 0, -1)),
    "N": ("1", (1, 1, -2)),
    "Pa": ("1", (-1, 1, -2)),
    "bar": ("1e5", (-1, 1, -2)),
    "J": ("1", (2, 1, -2)),
    "W": ("1", (2, 1, -3)),
    "rad": ("1", (0, 0, 0)),
    "deg": ("0.01745329251994329576923690768", (0, 0, 0)),
    "rpm": ("0.1047197551196597746154214461", (0, 0, -1)),
    "inch": ("0.0254", (1, 0, 0)),
    "ft": ("0.3048", (1, 0, 0)),
    "lb": ("0.45359237", (0, 1, 0)),
    "lbf": ("4.4482216152605", (1, 1, -2)),
    "psi": ("6894.757293168361", (-1, 1, -2)),
}
_PREFIXES = {"T": 12, "G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6}
_POWERS = str.maketrans({"²": "^2", "³": "^3", "·": " "})
_BARE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*", re.ASCII)
_QUANTITY = re.compile(_BARE.pattern + r"([^\W\d_].*)")
_FACTOR = re.compile(r"([^\W\d_]+)(?:\^([-+]?\d{1,2}))?")

_KINDS = {
    "s": ("a time", "0.02 s"),
    "m": ("a length", "2.25 m"),
    "kg": ("a mass", "30 t"),
    "kg m^2": ("a moment of inertia", "1e5 kg m^2"),
    "kg/m^3": ("a density", "1500 kg/m^3"),
    "Pa": ("a stress or modulus", "45 GPa"),
    "Pa s": ("a viscosity", "20 MPa s"),
    "N m": ("a torque", "-36000 kN m"),
    "N m/rad": ("a stiffness against rotation", "50 MN m/rad"),
    "N m/s": ("a rate of torque", "15 kN m/s"),
    "N m s^2/rad^2": ("a torque per speed squared", "2.33 N m s^2/rad^2"),
    "W": ("a power", "5 MW"),
    "N m s/rad": ("a damping of rotation", "500 kN m s/rad"),
    "rad": ("an angle", "90 deg"),
    "rad/s": ("a speed of rotation", "12 rpm"),
    "m/s": ("a speed", "10 m/s"),
    "m/s^2": ("an acceleration", "9.81 m/s^2"),
    "": ("a number", "0.3"),
}
"""Name of a quantity in an SI unit, and an example."""


def to_si(value: Any, unit: str) -> float:
    """A bare number as it is, a string with a unit in SI.

    A unit is a product such as ``kN m``, ``MN*m``, ``m/s^2``, ``g/cm**3``; after each slash stands
    one factor.

    Args:
        value: Number or string.
        unit: The SI unit that is expected, a key of the table of kinds, for example "Pa".

    Returns:
        The number in that unit.

    Raises:
        ValueError: if it is not a finite quantity of this kind.
    """
    number = nan
    with suppress(ValueError, ArithmeticError):
        if isinstance(value, Real) and not isinstance(value, bool):
            number = float(value)
        elif isinstance(value, str):
            number = _number(value, unit)
    if isfinite(number):
        return number
    kind, example = _KINDS[unit]
    if not unit:
        raise ValueError(f"expected {kind}, for example {example}")
    raise ValueError(f'expected {kind}, for example "{example}"; a bare number counts in {unit}')


def _number(text: str, unit: str) -> float:
    """The number of a string with or without a unit, in a unit; ValueError if that fails."""
    if _BARE.fullmatch(text):
        return float(text)
    match = _QUANTITY.fullmatch(text.translate(_POWERS))
    if match is None:
        raise ValueError(text)
    (factor, powers), (wanted, wanted_powers) = _parse(match[2]), _parse(unit)
    if powers != wanted_powers or (unit == "rad/s" and "Hz" in match[2]):  # 2 pi rad/s, not 1
        raise ValueError(text)
    return float(match[1]) * float(factor / wanted)


def _parse(unit: str) -> tuple[Decimal, Powers]:
    """Factor to SI and powers of a product of units."""
    factor, powers = Decimal(1), [0, 0, 0]
    for place, part in enumerate(unit.replace("**", "^").replace("*", " ").split("/")):
        names = part.split()
        if place > 0 and len(names) != 1:
            raise ValueError("one factor after a slash")
        for name in names:
            match = _FACTOR.fullmatch(name)
            if match is None:
                raise ValueError(name)
            exponent = int(match[2] or 1) * (-1 if place > 0 else 1)
            value, own = _unit(match[1])
            factor *= value**exponent
            powers = [p + exponent * q for p, q in zip(powers, own, strict=True)]
    return factor, tuple(powers)


def _unit(name: str) -> tuple[Decimal, Powers]:
    """Value in SI and powers of one unit with or without a prefix."""
    if name in _UNITS:
        value, powers = _UNITS[name]
        return Decimal(value), powers
    if name[0] in _PREFIXES and name[1:] in _UNITS:
        value, powers = _UNITS[name[1:]]
        return Decimal(value).scaleb(_PREFIXES[name[0]]), powers
    raise ValueError(name)


@dataclass(frozen=True)
class Unit:
    """Marks the SI unit of a number in the type of a key.

    Args:
        symbol: The unit, empty for none.
    """

    symbol: str

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Numbers may be strings that begin with a number, as in "45 GPa"."""
        text = {"type": "string", "pattern": r"^\s*[-+]?\.?[0-9]"}
        return {"anyOf": [handler(schema), text]}


@dataclass(frozen=True)
class Quantity(Unit):
    """The unit of a number that may also be given as a string with another unit."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Pydantic converts to SI before it looks at the number."""
        return core_schema.no_info_before_validator_function(
            lambda value: to_si(value, self.symbol), handler(source)
        )


def unit_of(kind: Any) -> str | None:
    """SI unit of a type, or of the parts of a tuple or a union; None if it is no quantity."""
    for mark in getattr(kind, "__metadata__", ()):
        if isinstance(mark, Unit):
            return mark.symbol
    inner = (getattr(kind, "__origin__", None), *get_args(kind))
    found = [unit_of(part) for part in inner if part is not None and part is not kind]
    return next((unit for unit in found if unit is not None), None)


def require_number(value: Any) -> Any:
    """The number itself, or ValueError for what can be none: `true`, text, lists."""
    if isinstance(value, bool | str) or not isinstance(value, Real):
        raise ValueError("expected a whole number, for example 2")
    return value


Seconds = Annotated[float, Quantity("s")]
Metres = Annotated[float, Quantity("m")]
Kilograms = Annotated[float, Quantity("kg")]
EulerMoment = Annotated[float, Quantity("kg m^2")]
Density = Annotated[float, Quantity("kg/m^3")]
Pascal = Annotated[float, Quantity("Pa")]
Viscosity = Annotated[float, Quantity("Pa s")]
Torque = Annotated[float, Quantity("N m")]
TorsionalStiffness = Annotated[float, Quantity("N m/rad")]
TorsionalDamping = Annotated[float, Quantity("N m s/rad")]
TorqueRate = Annotated[float, Quantity("N m/s")]
TorqueGain = Annotated[float, Quantity("N m s^2/rad^2")]
Power = Annotated[float, Quantity("W")]
Radians = Annotated[float, Quantity("rad")]
AngularSpeed = Annotated[float, Quantity("rad/s")]
Speed = Annotated[float, Quantity("m/s")]
Acceleration = Annotated[float, Quantity("m/s^2")]
Number = Annotated[float, Quantity("")]
Whole = Annotated[int, BeforeValidator(require_number)]
