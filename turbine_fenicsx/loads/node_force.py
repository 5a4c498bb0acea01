"""Force on a node of a flexible body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy.typing as npt

from turbine_fenicsx.flexible_body import FlexibleBody
from turbine_fenicsx.time_functions import ALWAYS


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
    """

    name: str
    flexible: FlexibleBody
    point: npt.ArrayLike
    force: npt.ArrayLike
    function: Callable[[float], float] = ALWAYS
