"""The model that each kind of body has."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from typing import Any

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.reduced_model import ReducedModel


@singledispatch
def make_model(
    body: DeformableBody,
    forces: Sequence[Any],
    damping: RayleighDamping | None,
    couplings: Sequence[Coupling],
) -> BodyModel:
    """The model of a body. Collective.

    ``make_model.register(MyBody, my_model)`` adds that of a new kind: ``my_model`` is
    called with these arguments.

    Args:
        forces: Forces on its nodes, masses, surfaces and sections.
        damping: Its Rayleigh damping; None is none.
        couplings: The couplings that hold it.

    Raises:
        TypeError: for a kind that has none.
    """
    raise TypeError(f"{describe(body)} has no model; make_model.register adds one")


@make_model.register(FlexibleBody)
def _make_flexible(
    body: FlexibleBody,
    forces: Sequence[Any],
    damping: RayleighDamping | None,
    _: Sequence[Coupling],
) -> FlexibleModel:
    """The model of a body on its mesh, which needs no couplings."""
    return FlexibleModel(body, forces, damping)


make_model.register(ReducedBody, ReducedModel)


def on_mesh(model: BodyModel, what: str) -> FlexibleModel:
    """The model as one whose nodes are those of a mesh.

    Args:
        what: What needs the mesh, for the error.
    """
    if not isinstance(model, FlexibleModel):
        raise ModelError(f"{what} need a body on a mesh, and {model.body.name!r} is reduced")
    return model
