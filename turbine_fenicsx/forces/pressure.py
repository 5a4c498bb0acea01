"""Pressure on the surface of a flexible body, a follower load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import ufl

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_number


@dataclass(frozen=True, eq=False)
class Pressure:
    """A force -p n per present area, n the present normal: -p cof(F) N per reference area.

    Args:
        name: Name under which its work is reported.
        flexible: The body.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        pressure: p [N/m^2], positive inwards.
        function: Factor as a function of time [s].

    Raises:
        ModelError: if the pressure is not a number.
        TypeError: if the function is not one of time.
    """

    name: str
    flexible: FlexibleBody
    facets: npt.NDArray[np.int32]
    pressure: float
    function: Callable[[float], float] = ALWAYS

    def __post_init__(self) -> None:
        check_number(f"pressure of {self.name!r}", self.pressure)
        check_function(self.name, self.function)

    def traction(self, at: SurfacePoint) -> Any:
        """-factor p cof(F) N."""
        return -at.factor * at.parameter(self.pressure) * ufl.det(at.F) * ufl.inv(at.F).T * at.N
