"""Redundant constraints: which rows of a Jacobian say nothing new."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr

from turbine_fenicsx.rotations import Array

TOLERANCE = 1e-9
"""A row counts as dependent if less than this part of it is independent of the others."""


def redundant_rows(G: Array, first: int) -> npt.NDArray[np.int64]:
    """Rows that depend on the others, found by orthogonal factorisation with column pivoting.

    Args:
        G: Jacobian, shape (rows, coordinates); rows that are zero are redundant.
        first: The rows before this one are independent of each other and are kept.

    Returns:
        Sorted numbers of the rows to leave out; the others have full rank.
    """
    lengths = np.linalg.norm(G, axis=1)
    unit = G / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    Q = np.linalg.qr(unit[:first].T)[0]
    rest = unit[first:] - (unit[first:] @ Q) @ Q.T
    if not rest.size:
        return np.zeros(0, np.int64)
    R, order = qr(rest.T, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank = int(np.count_nonzero(diagonal > TOLERANCE))
    return np.sort(first + order[rank:]).astype(np.int64)
