"""Coupling of a flexible body to a rigid body or the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody


@dataclass(frozen=True, eq=False)
class Coupling:
    """Nodes of a surface of a flexible body that move with a rigid body.

    Args:
        name: Unique name.
        flexible: The flexible body.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        rigid: The carrying rigid body, None for the ground.
    """

    name: str
    flexible: FlexibleBody
    facets: npt.NDArray[np.int32]
    rigid: RigidBody | None
