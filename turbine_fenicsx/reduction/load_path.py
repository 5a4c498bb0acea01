"""Loads that a body is bent by, one after the other, before it is reduced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Forces that change with time, and the times at which the body is brought into equilibrium.

    Args:
        name: A name for reports.
        forces: Forces on the flexible body, and gravity.
        times: When its equilibria are wanted [s]; rising, from above 0 on. At time 0 the body is
            undeformed.

    Raises:
        TypeError: if the forces are no sequence.
        ModelError: for other times.
    """

    name: str
    forces: Sequence[Any]
    times: Sequence[float] = (0.2, 0.6, 1.0)

    def __post_init__(self) -> None:
        if not isinstance(self.forces, Sequence):
            raise TypeError(
                f"forces of {self.name!r} must be a sequence, got {describe(self.forces)}"
            )
        times = np.asarray(self.times, dtype=float)
        rising = times.ndim == 1 and times.size and np.all(np.diff(times, prepend=0.0) > 0.0)
        if not rising or not np.all(np.isfinite(times)):
            raise ModelError(
                f"times of {self.name!r} must rise from above zero, got {self.times!r}"
            )


def check_loads(loads: Any) -> None:
    """Raise a TypeError if loads are not a sequence of paths, a ModelError for equal names."""
    if not isinstance(loads, Sequence) or not all(isinstance(x, LoadPath) for x in loads):
        raise TypeError(f"loads must be a sequence of LoadPaths, got {describe(loads)}")
    names = [path.name for path in loads]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ModelError(f"names of load paths must be unique, but {twice} occur more than once")
