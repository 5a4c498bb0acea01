"""Bodies that deform, however they are discretised."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from turbine_fenicsx.bodies.placement import Placement


class DeformableBody:
    """A body that deforms: base of all kinds, each with a model and a step.

    A new kind registers both, see `turbine_fenicsx.system.make_model.make_model` and
    `turbine_fenicsx.time_stepping.energy_momentum.make_step`.

    Attributes:
        name: Unique name.
        full: The `FlexibleBody` or `Carrier` to whose mesh facets, points and pictures refer.
        placements: Where each copy of the mesh stands; one copy where it is by default.
        displacement: What its model makes the initial displacement of; None if that is zero.
    """

    name: str
    full: Any
    placements: Sequence[Placement] = (Placement(),)
    displacement: Any = None
