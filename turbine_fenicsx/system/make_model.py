"""The model that a kind of body has."""

from __future__ import annotations

from collections.abc import Sequence

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.flexible_model import BodyForce, FlexibleModel


def make_model(
    body: DeformableBody, forces: Sequence[BodyForce], damping: RayleighDamping | None
) -> BodyModel:
    """The model of a body. Collective.

    Args:
        body: The body.
        forces: The forces on it.
        damping: Its Rayleigh damping; None is none.
    """
    return FlexibleModel(body, forces, damping)


def on_mesh(model: BodyModel, what: str) -> FlexibleModel:
    """The model as one whose nodes are those of a mesh.

    Args:
        model: The model of a body.
        what: What needs the mesh, for the error.

    Raises:
        ModelError: for another kind of model.
    """
    if not isinstance(model, FlexibleModel):
        raise ModelError(f"{what} need a body on a mesh, and {model.body.name!r} is reduced")
    return model
