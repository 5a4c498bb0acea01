"""Initial displacements and velocities of flexible bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.special import roots_legendre

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel

LARGEST_PART = 1e-9
"""Maximum gap of a coupling relative to the largest position or displacement of its nodes."""


def initial_displacement(
    block: FlexibleModel, coupling: CouplingBlock, coordinates: Mapping[RigidBody, Array]
) -> Array:
    """Initial displacements of the owned nodes of a flexible body.

    Args:
        block: The flexible block.
        coupling: Its couplings.
        coordinates: q of each rigid body, shape (12,).

    Returns:
        Shape (n_owned, 3) [m].

    Raises:
        ModelError: if the displacement has another shape, is not finite, turns cells inside out or
            opens a coupling, on all ranks.

    Note:
        Collective.
    """
    X, field = block.positions, block.body.displacement
    if field is None:
        return np.zeros_like(X)
    values = _evaluate(block, "displacement", field)
    _check_cells(block, values)
    u, comm = block.new_vector(), block.body.mesh.comm
    u.array[:] = values.ravel()
    gaps = np.abs(coupling.gap(coordinates, u)).reshape(-1, 3)
    u.destroy()
    sizes = (np.abs(X) + np.abs(values))[coupling.nodes]
    for c, rows in zip(coupling.couplings, coupling.slices, strict=True):
        mine = [np.max(part[rows], initial=0.0) for part in (gaps, sizes)]
        gap, size = np.max(comm.allgather(mine), axis=0)
        if gap > LARGEST_PART * size:
            raise ModelError(
                f"the displacement of {block.body.name!r} opens coupling {c.name!r} by {gap:.3g} m "
                f"(allowed: {LARGEST_PART * size:.1g} m): nodes of a coupling must stay where they "
                "are"
            )
    return values


def _check_cells(block: FlexibleModel, displacements: Array) -> None:
    """Raise a ModelError if det F is not positive in all cells. Collective."""
    body, comm = block.body, block.body.mesh.comm
    kind = _compat.cell_name(body.mesh)
    u = block.new_vector()
    u.array[:] = displacements.ravel()
    _, dN = _compat.shape_functions(kind, body.degree, _gauss_points(kind, body.degree))
    cells = _compat.dofs_of_cells(block.space)
    X, x = block.local_positions, block.local_positions + block.nodal_values(u)
    u.destroy()
    before, after = (np.linalg.det(np.einsum("qaj,cai->cqij", dN, p[cells])) for p in (X, x))
    owned = body.mesh.topology.index_map(3).size_local
    wrong = np.flatnonzero((after / before)[:owned].min(axis=1, initial=np.inf) <= 0.0)
    places = [place for own in comm.allgather(X[cells[wrong]].mean(axis=1)) for place in own]
    if places:
        raise ModelError(
            f"the displacement of {body.name!r} turns {len(places)} "
            f"cell{'s' * (len(places) > 1)} inside out, one of them at "
            f"({', '.join(f'{c:.4g}' for c in places[0])})"
        )


def _gauss_points(kind: str, degree: int) -> Array:
    """Points inside of the reference cell, shape (n, 3)."""
    if kind == "hexahedron":
        one = 0.5 + 0.5 * roots_legendre(degree + 1)[0]
        found: Array = np.stack(np.meshgrid(one, one, one), axis=-1).reshape(-1, 3)
        return found
    a, b = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
    return np.array([[a, a, a], [b, a, a], [a, b, a], [a, a, b]])


def initial_velocity(
    block: FlexibleModel, coupling: CouplingBlock, rates: Array, displacements: Array
) -> Array:
    """Initial velocities of the owned nodes of a flexible body.

    Args:
        block: The flexible block.
        coupling: Its couplings.
        rates: Rates of the coordinates of all rigid bodies, shape (12 bodies,).
        displacements: Initial displacements of the owned nodes, shape (n_owned, 3) [m].

    Returns: Its own velocity field if it has one, else that of its first parent body, else rest;
        shape (n_owned, 3) [m/s].

    Raises:
        ModelError: if the velocity field has another shape or is not finite, on all ranks.

    Note:
        Collective.
    """
    X = block.positions
    if block.body.velocity is not None:
        return _evaluate(block, "velocity", block.body.velocity)
    if coupling.carriers:
        xi = coupling.carriers[0].body_coordinates(X + displacements)
        of_carrier = rates[coupling.columns[:12]].reshape(4, 3)
        velocities: Array = of_carrier[0] + xi @ of_carrier[1:]
        return velocities
    return np.zeros_like(X)


def _evaluate(block: FlexibleModel, what: str, field: Callable[[Array], Array] | Array) -> Array:
    """Values at the owned nodes; a function never sees three points, where (n, 3) is (3, n)."""
    X = block.positions
    points = np.concatenate([X, X[:1]]) if len(X) == 3 and callable(field) else X
    found, error = np.zeros_like(points), None
    try:
        if len(points):
            given = field(points.copy()) if callable(field) else field
            found = _check_values(f"{what} of {block.body.name!r}", given, points.shape)
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(block.body.mesh.comm, error)
    values: Array = found[: len(X)]
    return values


def _check_values(what: str, values: Array, shape: tuple[int, ...]) -> Array:
    """Values of the right shape and finite, or a ModelError."""
    values = np.asarray(values)
    if values.shape != shape:
        raise ModelError(
            f"{what} must have one row per point, shape {shape} for positions of that shape; "
            f"it has shape {values.shape}"
        )
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{what} must be finite, but some of its values are not")
    return values.astype(float)
