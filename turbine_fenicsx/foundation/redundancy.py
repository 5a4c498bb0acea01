"""Redundant constraints: which rows of a Jacobian say nothing new."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array

TOLERANCE = 1e-9
"""Independent share of a row below which it counts as dependent on those before it."""


def find_redundant_rows(G: Array, first: int) -> npt.NDArray[np.int64]:
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
    if first >= rows:
        return np.zeros(0, np.int64)
    lengths = np.linalg.norm(G, axis=1)
    unit = G / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    start = np.linalg.qr(unit[:first].T)[0]
    rest = _project_out(start, unit[first:].T).T
    basis = np.zeros((size, min(rows - first, size)))  # orthonormal columns, the rank so far
    rank, dependent = 0, []
    for k, row in enumerate(rest):
        row = _project_out(basis[:, :rank], row)
        length = float(np.linalg.norm(row))
        if length > TOLERANCE:
            basis[:, rank] = row / length
            rank += 1
        else:
            dependent.append(first + k)
    return np.array(dependent, dtype=np.int64)


def _project_out(basis: Array, columns: Array) -> Array:
    """Part of columns normal to the space of an orthonormal basis."""
    for _ in range(2):  # once is not enough for columns that nearly lie in it
        columns = columns - basis @ (basis.T @ columns)
    return columns
