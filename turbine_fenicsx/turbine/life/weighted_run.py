"""A run that stands for a part of the life of a turbine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError

YEAR = 365.25 * 24.0 * 3600.0
"""Seconds of a year."""

SUM = 1e-6
"""Weights sum up to 1 within this."""


@dataclass(frozen=True)
class WeightedRun:
    """A run, and how often it happens.

    Args:
        folder: Its output folder.
        name: For tables.
        begin: Time before which nothing counts [s].
        share: Part of the life that is like this run [-].
        times: How often it happens in the life, in place of a share.
    """

    folder: Path
    name: str
    begin: float = 0.0
    share: float = 1.0
    times: float | None = None

    def find_times(self, duration: float, years: float) -> float:
        """How often it happens in a life.

        Args:
            duration: The time of it that counts [s].
            years: The life.
        """
        return self.share * years * YEAR / duration if self.times is None else self.times


def weigh(folders: Sequence[str], weights: Sequence[float], begin: float) -> list[WeightedRun]:
    """Runs that each stand for a part of the life.

    Args:
        weights: A number for each; equal ones if empty.

    Raises:
        InputError: for another number of weights, negative ones, or a sum that is not 1.
    """
    n = len(folders)
    shares = list(weights) or [1.0 / n] * n
    if len(shares) != n:
        raise InputError(f"--weights: expected {n} numbers, one for each run, got {len(shares)}")
    total = sum(shares)
    if min(shares) < 0.0 or not abs(total - 1.0) < SUM:
        text = ",".join(f"{x:g}" for x in shares)
        raise InputError(
            f"--weights {text}: expected parts of the life from 0 to 1 that sum up to 1, not "
            f"{total:g}"
        )
    doubled = [
        x for x in folders if [Path(y).resolve() for y in folders].count(Path(x).resolve()) > 1
    ]
    if doubled:
        raise InputError(f"the run {doubled[0]!r} is given twice")
    return [WeightedRun(Path(x), x, begin, w) for x, w in zip(folders, shares, strict=True)]
