"""Force on a node of a flexible body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_vectors


@dataclass(frozen=True, eq=False)
class NodeForce:
    """A force with a direction fixed in space on the node nearest to a point.

    In a continuum a force on a point has an infinite displacement as the mesh is refined; where
    that matters, take a `SurfaceTraction`.

    Args:
        name: Name under which its work is reported.
        flexible: The body.
        point: Point in the initial configuration [m], shape (3,).
        force: Force [N], shape (3,).
        function: Factor as a function of time [s].

    Raises:
        ModelError: if point or force are not three numbers.
        TypeError: if the function is not one of time.
    """

    name: str
    flexible: DeformableBody
    _: KW_ONLY
    point: npt.ArrayLike
    force: npt.ArrayLike
    function: Callable[[float], float] = ALWAYS

    def __post_init__(self) -> None:
        check_vectors(self.name, point=self.point, force=self.force)
        check_function(self.name, self.function)
