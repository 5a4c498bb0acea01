"""Strain coordinates of a reduced body: few where states are known, else those of all pairs.

Pairs are of two kinds: those with a director (1), whose scalar products change in proportion to
displacements, and all others (2). With K11 = C C^T and S22 = K22 - K21 K11^-1 K12

    W = | C            0     |        Z = X^T V X,   X = K^-1 W = | C^-T   -K11^-1 K12 Y |
        | K21 C^-T     S22 Y |                                    | 0       Y            |

where the columns of Y are an orthogonal decomposition of the changes e_2 of states, of which as
many are kept as are wanted, Y^T S22 Y = 1. Stiffness and viscosity at rest are exact however few
these are, and the energy is never more than that of all pairs. W is turned until Z is diagonal.

With functions f_k and vectors y_k the strain at a quadrature point is B e, with the changes e_p of
the scalar products of all pairs p = (k, l), k <= l, and the columns of B

    sym(grad f_k (x) grad f_l), half of it for k = l.

So K = sum_q w_q B^T D B is the same for any motion, with the quadrature of the full body: the
reduced energy is that of the full body in the reduced motion, without a sample or a fit.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpstrf

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


SMALLEST = 1e-12
"""Square that counts as zero, relative to the largest."""


def choose_strains(K: Array, V: Array | None, states: Array, wanted: int) -> tuple[Array, Array]:
    """W and the diagonal of Z from some states.

    Args:
        K: Stiffness of the pairs, shape (pairs, pairs) [J].
        V: Their viscosity, of the same shape; None for none.
        states: Changes e of the scalar products in each state, shape (states, pairs).
        wanted: Maximum number of coordinates beyond those of pairs with a director.

    Returns:
        Shapes (pairs, r) and (r,) [s], the latter (0,) without viscosity.
    """
    m = round(np.sqrt(2 * len(K) + 0.25) - 0.5)
    first = np.triu_indices(m)[0] < min(3, m)
    scale = 1.0 / np.sqrt(np.where(np.diag(K) > 0.0, np.diag(K), 1.0))
    K = K * scale * scale[:, None]
    K11, K21, K22 = K[np.ix_(first, first)], K[np.ix_(~first, first)], K[np.ix_(~first, ~first)]
    squares, axes = np.linalg.eigh(K11)
    kept = squares > SMALLEST * squares[-1]  # functions may depend on each other
    C, C_inverse = (axes[:, kept] * squares[kept] ** power for power in (0.5, -0.5))
    K21_C = K21 @ C_inverse  # K21 C^-T
    E = (states / scale).T[~first]
    SE = K22 @ E - K21_C @ (K21_C.T @ E)
    squares, weights = np.linalg.eigh(E.T @ SE)
    order = np.argsort(squares)[::-1][:wanted]
    order = order[squares[order] > SMALLEST * max(squares.max(initial=0.0), 0.0)]
    weights = weights[:, order] / np.sqrt(squares[order])
    Y, n = E @ weights, C.shape[1]
    W = np.zeros((len(K), n + len(order)))
    W[np.ix_(first, np.arange(n))] = C
    W[~first, :n], W[~first, n:] = K21_C, SE @ weights
    if V is None:
        return W / scale[:, None], np.zeros(0)
    X = np.zeros_like(W)
    X[first] = C_inverse @ np.concatenate([np.eye(n), -K21_C.T @ Y], axis=1)
    X[~first, n:] = Y
    W, Z = _diagonalise(W, X.T @ (V * scale * scale[:, None]) @ X)
    return W / scale[:, None], Z


def keep_all_strains(K: Array, V: Array | None) -> tuple[Array, Array]:
    """W with K = W W^T of full rank, and the diagonal of Z, with V = W Z W^T.

    Args:
        V: As of `choose_strains`, zero where K is.
    """
    scale = np.sqrt(np.maximum(np.diag(K), 0.0))
    scale[scale == 0.0] = 1.0
    c, pivots, rank, _ = dpstrf(K / scale / scale[:, None], lower=1)
    order = pivots - 1
    L = np.tril(c)[:, :rank]
    W = np.empty_like(L)
    W[order] = scale[order, None] * L
    if V is None:
        return W, np.zeros(0)
    first = order[:rank]
    of_pivots = (V / scale / scale[:, None])[np.ix_(first, first)]
    half = solve_triangular(L[:rank], of_pivots, lower=True)
    return _diagonalise(W, solve_triangular(L[:rank], half.T, lower=True))


def _diagonalise(W: Array, Z: Array) -> tuple[Array, Array]:
    """W Q and the diagonal of Q^T Z Q."""
    times, axes = np.linalg.eigh(0.5 * (Z + Z.T))
    return W @ axes, np.maximum(times, 0.0)
