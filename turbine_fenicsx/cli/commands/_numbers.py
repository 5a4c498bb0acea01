"""Options that take several numbers."""

from __future__ import annotations

from math import isfinite

from turbine_fenicsx.foundation.errors import InputError


def parse_numbers(option: str, text: str) -> list[float]:
    """Finite numbers separated by commas.

    Args:
        option: Name of the option, for the error.
        text: What the user wrote.

    Raises:
        InputError: if it is something else.
    """
    try:
        found = [float(number) for number in text.split(",")]
    except ValueError:
        found = [float("nan")]
    if not all(isfinite(number) for number in found):
        raise InputError(f"{option} {text}: give numbers separated by commas")
    return found
