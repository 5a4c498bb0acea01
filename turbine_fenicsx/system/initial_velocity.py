"""Initial velocities of flexible bodies."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel


def initial_velocity(block: FlexibleModel, coupling: CouplingBlock, rates: Array) -> Array:
    """Initial velocities of the owned nodes of a flexible body.

    Args:
        block: The flexible block.
        coupling: Its couplings.
        rates: Rates of the coordinates of all rigid bodies, shape (12 bodies,).

    Returns:
        Its own velocity field if it has one, else that of its first carrier, else rest;
        shape (n_owned, 3) [m/s].

    Raises:
        ModelError: if the velocity field has another shape or is not finite, on all ranks.

    Note:
        Collective.
    """
    X = block.positions
    if block.body.velocity is not None:
        return _evaluate(block, block.body.velocity)
    if coupling.carriers:
        xi = coupling.carriers[0].body_coordinates(X)
        of_carrier = rates[coupling.columns[:12]].reshape(4, 3)
        velocities: Array = of_carrier[0] + xi @ of_carrier[1:]
        return velocities
    return np.zeros_like(X)


def _evaluate(block: FlexibleModel, field: Callable[[Array], Array]) -> Array:
    """Values of a field at the owned nodes; never at three points, where (n, 3) is (3, n)."""
    X = block.positions
    points = np.concatenate([X, X[:1]]) if len(X) == 3 else X
    found, error = np.zeros_like(points), None
    try:
        if len(points):
            found = _check_velocities(
                f"velocity of {block.body.name!r}", field(points.copy()), points.shape
            )
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(block.body.mesh.comm, error)
    velocities: Array = found[: len(X)]
    return velocities


def _check_velocities(what: str, values: Array, shape: tuple[int, ...]) -> Array:
    """Velocities of the right shape and finite, or a ModelError."""
    values = np.asarray(values)
    if values.shape != shape:
        raise ModelError(
            f"{what} must have one row per point, shape {shape} for positions of that shape; "
            f"it has shape {values.shape}"
        )
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{what} must be finite, but some of its values are not")
    return values.astype(float)
