"""Usual sizes of numbers: outside of them a unit or a sign is probably wrong."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi
from typing import Any

DEGREE = pi / 180.0

_SHOWN = {"rad": ("deg", DEGREE), "rad/s": ("deg/s", DEGREE)}
"""Units in which people read a quantity, and their value in SI."""


@dataclass(frozen=True)
class Plausible:
    """Marks the usual sizes of a number in the type of a key; zero is always usual.

    Args:
        whole: Whether of several numbers only the largest is judged, as of a curve.
    """

    low: float
    high: float
    whole: bool = False

    def find_outliers(self, values: Iterable[Any]) -> list[float]:
        """Numbers that are unusually small or large."""
        numbers = [float(x) for x in values if isinstance(x, int | float)]
        if self.whole and numbers:
            numbers = [max(numbers, key=abs)]
        return [x for x in numbers if x and not self.low <= abs(x) <= self.high]

    def describe(self, name: str, value: float, unit: str, advice: str) -> str:
        """The sentence about an unusual number.

        Args:
            name: What has it, a key for example.
        """
        shown, factor = _SHOWN.get(unit, (unit, 1.0))
        low, high, x = (number / factor for number in (self.low, self.high, value))
        after = f" {shown}" if shown else ""
        if shown.startswith("deg") and abs(x) < low:
            advice += "; is it in radians?"
        return f"{name} is {x:.4g}{after}, {low:.4g} to {high:.4g}{after} are usual; {advice}"
