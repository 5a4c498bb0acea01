"""Dead load on the surface of a flexible body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_vectors


@dataclass(frozen=True, eq=False)
class SurfaceTraction:
    """A force per reference area with a direction fixed in space.

    Args:
        name: Name under which its work is reported.
        flexible: The body.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        force: Force per reference area [N/m^2], shape (3,).
        function: Factor as a function of time [s].

    Raises:
        ModelError: if the force is not three numbers.
        TypeError: if the function is not one of time.
    """

    name: str
    flexible: FlexibleBody
    facets: npt.NDArray[np.int32]
    force: npt.ArrayLike
    function: Callable[[float], float] = ALWAYS

    def __post_init__(self) -> None:
        check_vectors(self.name, force=self.force)
        check_function(self.name, self.function)

    def traction(self, at: SurfacePoint) -> Any:
        """Factor t, whatever the deformation."""
        return at.factor * at.parameter(self.force)
