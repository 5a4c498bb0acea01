"""Dense linear equations with rows and columns of very different size."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from turbine_fenicsx.foundation.types import Array

EQUALISATIONS = 5
"""Rounds of scaling after which all rows are of about one size."""

NO_SIGN = 1e-13
"""Eigenvalues of a scaled matrix this small are round-off."""


class ScaledFactor:
    """LU factors of a matrix after scaling rows, then columns, to length one.

    Mass, constraint and angle rows differ by many powers of ten; unscaled, the condition number
    of the rigid block is 1e13 and more.

    Args:
        A: Shape (n, n).
    """

    def __init__(self, A: Array) -> None:
        self._size = len(A)
        if not self._size:
            return
        squares = A * A
        row_squares = _inverse(squares @ np.ones(self._size))
        self._rows = np.sqrt(row_squares)
        self._columns = np.sqrt(_inverse(row_squares @ squares))
        scaled = np.multiply(A, self._rows[:, None], out=squares)
        scaled *= self._columns
        # LAPACK reads columns first, and so finds the transposed matrix without a copy
        self._lu, self._pivots, self._singular = dgetrf(scaled.T, overwrite_a=True)

    def solve(self, b: Array) -> Array:
        """Solution of A x = b.

        Args:
            b: Shape (n,).

        Returns:
            Shape (n,); not-a-number if A is singular, so that the failure reaches all ranks
            through the next norm.
        """
        if not self._size:
            return np.zeros(0)
        if self._singular:
            return np.full(self._size, np.nan)
        y, _ = dgetrs(self._lu, self._pivots, self._rows * b, trans=1)
        return np.asarray(self._columns * y)


def count_negative(A: Array) -> int:
    """Number of negative eigenvalues of a symmetric matrix, also if its rows differ much in size.

    Args:
        A: Shape (n, n).
    """
    if not len(A):
        return 0
    sizes = np.ones(len(A))
    for _ in range(EQUALISATIONS):  # scaling on both sides changes no sign
        rows = np.abs(A * sizes * sizes[:, None]).max(axis=1)
        sizes *= np.sqrt(_inverse(rows))
    values = np.linalg.eigvalsh(A * sizes * sizes[:, None])
    return int(np.count_nonzero(values < -NO_SIGN))


def _inverse(sizes: Array) -> Array:
    """One over each size, one where it is zero."""
    return 1.0 / np.where(sizes > 0.0, sizes, 1.0)
