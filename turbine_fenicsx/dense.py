"""Dense linear equations with rows and columns of very different size."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.rotations import Array


def solve_scaled(A: Array, b: Array) -> Array:
    """Solution of A x = b by LU after scaling rows and columns to largest entry one.

    Mass, constraint and angle rows differ by many powers of ten; unscaled, the condition number
    of the rigid block is 1e13 and more.

    Args:
        A: Shape (n, n).
        b: Shape (n,).

    Returns:
        Shape (n,); not-a-number if A is singular, so that the failure reaches all ranks through
        the next norm.
    """
    if b.size == 0:
        return np.zeros(0)
    rows = np.abs(A).max(axis=1)
    scaled = A / np.where(rows > 0.0, rows, 1.0)[:, None]
    columns = np.abs(scaled).max(axis=0)
    columns = np.where(columns > 0.0, columns, 1.0)
    try:
        y = np.linalg.solve(scaled / columns, b / np.where(rows > 0.0, rows, 1.0))
    except np.linalg.LinAlgError:
        return np.full(b.size, np.nan)
    return y / columns
