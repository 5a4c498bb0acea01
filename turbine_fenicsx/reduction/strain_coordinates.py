"""Strain coordinates of a reduced body: few where states are known, else those of all pairs.

Pairs are of two kinds: those with a director (1), whose scalar products change in proportion to
displacements, and all others (2). With K11 = C C^T and S22 = K22 - K21 K11^-1 K12

    W = | C            0     |        Z = X^T V X,   X = K^-1 W = | C^-T   -K11^-1 K12 Y |
        | K21 C^-T     S22 Y |                                    | 0       Y            |

where the columns of Y are an orthogonal decomposition of the changes e_2 of states, of which as
many are kept as are wanted, Y^T S22 Y = 1. Stiffness and viscosity at rest are exact however few
these are, and the energy is never more than that of all pairs. W is turned until Z is diagonal.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpstrf

from turbine_fenicsx.foundation.types import Array

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
