"""Initial displacements and velocities that a body on a mesh is given: evaluated and checked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mpi4py import MPI

import numpy as np
from scipy.special import roots_legendre

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array


def evaluate_field(
    comm: MPI.Intracomm, what: str, positions: Array, field: Callable[[Array], Array] | Array
) -> Array:
    """Values of a field at points; a function never sees three points, where (n, 3) is (3, n).

    Args:
        positions: The points, shape (n, 3) [m].
        field: A function of such points, or its values.

    Returns:
        Shape (n, 3).

    Note:
        Collective.
    """
    X = positions
    points = np.concatenate([X, X[:1]]) if len(X) == 3 and callable(field) else X
    found, error = np.zeros_like(points), None
    try:
        if len(points):
            given = field(points.copy()) if callable(field) else field
            found = _check_values(what, given, points.shape)
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(comm, error)
    values: Array = found[: len(X)]
    return values


def check_cells(body: FlexibleBody, space: Any, positions: Array, displacements: Array) -> None:
    """Raise a ModelError if displacements turn cells of a body inside out. Collective.

    Args:
        positions: Initial positions of the local nodes, shape (nodes, 3) [m].
        displacements: Their displacements, of the same shape.
    """
    comm, kind = body.mesh.comm, _compat.cell_name(body.mesh)
    _, dN = _compat.shape_functions(kind, body.degree, _gauss_points(kind, body.degree))
    cells, X = _compat.dofs_of_cells(space), positions
    before, after = (
        np.linalg.det(np.einsum("qaj,cai->cqij", dN, p[cells])) for p in (X, X + displacements)
    )
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
