"""Redundant constraints: which rows of a Jacobian say nothing new."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.rotations import Array

TOLERANCE = 1e-9
"""A row counts as dependent if less than this part of it is independent of those before it."""


def redundant_rows(G: Array, first: int) -> npt.NDArray[np.int64]:
    """Rows that depend on those before them.

    The order decides: what closes a loop of joints is the last of them, and it loses all the rows
    that the loop has too many. Rows taken from several joints of a loop, such as those with the
    smallest pivots, would leave constraints that become dependent as the joints turn.

    Args:
        G: Jacobian, shape (rows, coordinates); rows that are zero are redundant.
        first: The rows before this one are independent of each other and are kept.

    Returns:
        Sorted numbers of the rows to leave out; the others have full rank.
    """
    rows, size = G.shape
    lengths = np.linalg.norm(G, axis=1)
    unit = G / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    basis = np.zeros((size, min(rows, size)))  # orthonormal columns, as many as the rank so far
    start = np.linalg.qr(unit[:first].T)[0]
    rank = start.shape[1]
    basis[:, :rank] = start
    dependent = []
    for k in range(first, rows):
        Q, row = basis[:, :rank], unit[k]
        for _ in range(2):  # once is not enough for rows that are nearly dependent
            row = row - Q @ (row @ Q)
        rest = float(np.linalg.norm(row))
        if rest > TOLERANCE:
            basis[:, rank] = row / rest
            rank += 1
        else:
            dependent.append(k)
    return np.array(dependent, dtype=np.int64)
