"""Initial displacements and velocities of flexible bodies."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.body_model import BodyModel
from turbine_fenicsx.system.coupling_block import CouplingBlock

LARGEST_PART = 1e-9
"""Maximum gap of a coupling relative to the largest position or displacement of its nodes."""


def initial_displacement(
    block: BodyModel, coupling: CouplingBlock, coordinates: Mapping[RigidBody, Array]
) -> Array:
    """Initial displacements of the owned nodes of a flexible body. Collective.

    Args:
        coordinates: q of each rigid body, shape (12,).

    Returns:
        Shape (n_owned, 3) [m].
    """
    values = block.initial_displacement()
    if block.body.displacement is None:
        return values
    u = block.new_vector()
    u.array[:] = values.ravel()
    gaps = np.abs(coupling.gap(coordinates, u)).reshape(-1, 3)
    u.destroy()
    sizes = (np.abs(block.positions) + np.abs(values))[coupling.nodes]
    for c, rows in zip(coupling.couplings, coupling.slices, strict=True):
        mine = [np.max(part[rows], initial=0.0) for part in (gaps, sizes)]
        gap, size = np.max(block.comm.allgather(mine), axis=0)
        if gap > LARGEST_PART * size:
            raise ModelError(
                f"the displacement of {block.body.name!r} opens coupling {c.name!r} by {gap:.3g} m "
                f"(allowed: {LARGEST_PART * size:.1g} m): nodes of a coupling must stay where they "
                "are"
            )
    return values


def initial_velocity(
    block: BodyModel, coupling: CouplingBlock, rates: Array, displacements: Array
) -> Array:
    """Initial velocities of the owned nodes of a flexible body. Collective.

    Args:
        rates: Rates of the coordinates of all rigid bodies, shape (12 bodies,).
        displacements: Initial displacements of the owned nodes, shape (n_owned, 3) [m].

    Returns: Its own velocity field if it has one, else that of its first parent body, else rest;
        shape (n_owned, 3) [m/s].
    """
    own = block.initial_velocity()
    if own is not None:
        return own
    if coupling.carriers:
        weights = coupling.carriers[0].weights_of(block.positions + displacements, block.is_point)
        of_carrier = rates[coupling.columns[:12]].reshape(4, 3)
        velocities: Array = weights[:, :1] * of_carrier[0] + weights[:, 1:] @ of_carrier[1:]
        return velocities
    return np.zeros_like(block.positions)
