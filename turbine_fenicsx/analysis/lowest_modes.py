"""The lowest modes of matrices that one rank holds, by ARPACK with a factor of the stiffness."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from turbine_fenicsx.foundation.types import Array


def find_lowest_modes(
    K: sparse.csr_matrix,
    M: sparse.csr_matrix,
    count: int,
    solve: Callable[[Array], Array],
    shift: float = 0.0,
) -> tuple[Array, Array]:
    """The lowest eigenvalues of K x = w^2 M x, in order, and their vectors of unit modal mass.

    Args:
        K: Stiffness, symmetric, shape (n, n).
        M: Mass, of the same shape.
        count: Number of modes, less than n.
        solve: Solves with K + shift M, shapes (n,).
        shift: The shift, positive where K is singular.

    Returns:
        w^2, shape (count,), and the vectors as columns, shape (n, count).
    """
    inverse = LinearOperator(K.shape, solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(K.shape[0])
    squares, shapes = eigsh(K, count, M, sigma=-shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], shapes[:, order]
