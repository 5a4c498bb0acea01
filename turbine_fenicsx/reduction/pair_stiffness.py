"""Stiffness of a body with respect to the scalar products of the vectors that move it.

With functions f_k and vectors y_k the strain at a quadrature point is B e, with the changes e_p of
the scalar products of all pairs p = (k, l), k <= l, and the columns of B

    sym(grad f_k (x) grad f_l), half of it for k = l.

So K = sum_q w_q B^T D B is the same for any motion, with the quadrature of the full body: the
reduced energy is that of the full body in the reduced motion, without a sample or a fit.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.parallel import raise_together, sum_over_ranks
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.elasticity import ENTRIES, Law
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.quadrature import stress_rule

CHUNK = 4_000_000
"""Maximum number of entries of B that are made together."""


def sum_pair_stiffness(
    model: FlexibleModel, law: Law, functions: Array, directors: int
) -> tuple[Array, Array | None]:
    """K of all pairs of functions, and the same of the viscosity. Collective.

    Args:
        functions: Values of the functions at the local nodes, ghosts included, shape (nodes, m).
        directors: Number of the first functions that are the coordinates X_1.. themselves, whose
            gradients are unit vectors.

    Returns:
        Shape (pairs, pairs) each; None without viscosity.
    """
    m = functions.shape[1]
    pairs = np.triu_indices(m)
    size = len(pairs[0])
    K, V = np.zeros((size, size)), np.zeros((size, size))
    error = None
    try:
        for gradients, weights, stiffness, viscosity in _list_points(model, law, functions):
            gradients[:, :directors] = np.eye(3)[:directors]
            B = _find_strains(gradients, pairs)
            _add(K, B, stiffness, weights)
            if viscosity is not None:
                _add(V, B, viscosity, weights)
    except Exception as problem:  # the other ranks must hear of it, whatever it is
        error = problem
    raise_together(model.comm, error)
    K = sum_over_ranks(model.comm, K)
    return K, sum_over_ranks(model.comm, V) if law.is_viscous else None


def _list_points(
    model: FlexibleModel, law: Law, functions: Array
) -> Iterator[tuple[Array, Array, Array, Array | None]]:
    """Gradients of the functions, weights and matrices at some quadrature points in turn."""
    body, (points, weights) = model.body, stress_rule(model.body)
    m = functions.shape[1]
    own = body.mesh.topology.index_map(3).size_local
    step = max(1, CHUNK // (3 * m * (m + 1)))
    derivatives = _compat.shape_functions(_compat.cell_name(body.mesh), body.degree, points)[1]
    nodes = _compat.dofs_of_cells(model.space)
    for first in range(0, own, step):
        cells = np.arange(first, min(first + step, own), dtype=np.int64)
        values = functions[nodes[cells]]
        for point, weight, dN in zip(points, weights, derivatives, strict=True):
            at = law.tabulate(cells, point)
            dx = np.linalg.inv(at.jacobians)
            gradients = np.einsum("cak,ai,cij->ckj", values, dN, dx, optimize=True)
            volumes = weight * np.abs(np.linalg.det(at.jacobians))
            yield gradients, volumes, at.stiffness, at.viscosity


def _find_strains(gradients: Array, pairs: tuple[IntArray, IntArray]) -> Array:
    """B of each point, shape (points, 6, pairs)."""
    a, b = (gradients[:, k] for k in pairs)  # shape (points, pairs, 3)
    B = np.empty((len(gradients), 6, len(pairs[0])))
    for row, (i, j) in enumerate(ENTRIES):
        B[:, row] = a[..., i] * b[..., j]
        if i != j:
            B[:, row] += a[..., j] * b[..., i]
    B[:, :, pairs[0] == pairs[1]] *= 0.5
    return B


def _add(K: Array, B: Array, D: Array, weights: Array) -> None:
    """Add sum_q w_q B^T D B."""
    squares, axes = np.linalg.eigh(0.5 * (D + D.swapaxes(1, 2)))
    roots = np.sqrt(weights[:, None] * np.maximum(squares, 0.0))
    rows = ((roots[:, None] * axes).swapaxes(1, 2) @ B).reshape(-1, B.shape[2])
    K += rows.T @ rows
