"""The model that a kind of body has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel


def make_model(
    body: DeformableBody,
    forces: Sequence[Any],
    damping: RayleighDamping | None,
    couplings: Sequence[Coupling],
) -> BodyModel:
    """The model of a body. Collective.

    Args:
        damping: Its Rayleigh damping; None is none.
    """
    if isinstance(body, ReducedBody):
        return ReducedModel(body, forces, damping, couplings)
    return FlexibleModel(body, forces, damping)


def on_mesh(model: BodyModel, what: str) -> FlexibleModel:
    """The model as one whose nodes are those of a mesh.

    Args:
        what: What needs the mesh, for the error.
    """
    if not isinstance(model, FlexibleModel):
        raise ModelError(f"{what} need a body on a mesh, and {model.body.name!r} is reduced")
    return model
