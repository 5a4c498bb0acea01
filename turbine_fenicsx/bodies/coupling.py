"""Coupling of a flexible body to a rigid body or the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True, eq=False)
class Coupling:
    """Nodes of a surface of a flexible body that move with a rigid body.

    Args:
        name: Unique name.
        flexible: The flexible body.
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        rigid: The carrying rigid body, None for the ground.
        copy: Number of the copy of a reduced body that is held, see `ReducedBody`.

    Raises:
        ModelError: for a copy that is not a whole number, or that the body does not have.
    """

    name: str
    flexible: DeformableBody
    facets: npt.NDArray[np.int32]
    rigid: RigidBody | None
    copy: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.copy, bool) or not isinstance(self.copy, int):
            raise ModelError(f"copy of {self.name!r} must be a whole number, got {self.copy!r}")
        if self.copy and self.copy not in range(copies := len(self.flexible.placements)):
            raise ModelError(
                f"copy of {self.name!r} must be one of the {copies} copies of "
                f"{self.flexible.name!r}, 0 to {copies - 1}, got {self.copy}"
            )
