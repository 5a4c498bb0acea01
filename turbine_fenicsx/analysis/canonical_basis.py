"""One choice among all bases of a space of modes, the same on any number of ranks.

A mode has a sign, and modes of one frequency may be mixed at will: blades that are equal, a beam
whose section is square, the rigid motions of a free body. Here the first is the one that moves
most at some coordinate, which is positive there; the others do not move there, and so on. Of equal
blades, each then moves alone.
"""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import FlatVectors
from turbine_fenicsx.foundation.types import Array

EQUAL_TOLERANCE = 1e-6
"""Motions that differ by less than this part count as equal; among them position decides."""


def choose_basis(flat: FlatVectors, vectors: Sequence[PETSc.Vec]) -> None:
    """Turn orthonormal vectors into the basis of their space that is described above.

    Note:
        Collective.
    """
    X = np.column_stack([y.array_r for y in vectors])
    for k in range(X.shape[1]):
        rest = X[:, k:]
        row = _largest_row(flat, rest)
        X[:, k:] = rest @ _reflection(row)
    for y, values in zip(vectors, X.T, strict=True):
        y.array[:] = values


def choose_phase(flat: FlatVectors, a: PETSc.Vec, b: PETSc.Vec) -> None:
    """Turn a + i b so that it is real and positive where it is largest. Collective."""
    real, imaginary = _largest_row(flat, np.column_stack([a.array_r, b.array_r]))
    turned = (a.array_r + 1j * b.array_r) * np.exp(-1j * np.arctan2(imaginary, real))
    a.array[:], b.array[:] = turned.real, turned.imag


def _largest_row(flat: FlatVectors, X: Array) -> Array:
    """The row of greatest length on all ranks, shape (k,); the first in space of equal ones."""
    comm = flat.system.comm
    lengths = np.sqrt(np.einsum("ij,ij->i", X, X))
    longest = max(comm.allgather(float(np.max(lengths, initial=0.0))))
    chosen = np.flatnonzero(lengths >= (1.0 - EQUAL_TOLERANCE) * longest)
    candidates = [(flat.place_of(int(i)), X[i].tolist()) for i in chosen]
    found = comm.allgather(min(candidates, default=None))
    return np.array(min(f for f in found if f is not None)[1])


def _reflection(row: Array) -> Array:
    """Orthogonal matrix H with a positive first entry and zeros elsewhere in row @ H."""
    size = float(np.linalg.norm(row))
    if not size:
        return np.eye(row.size)
    e = row / size
    if row.size == 1:
        return e[:, None]
    v = e.copy()
    v[0] += 1.0 if e[0] >= 0.0 else -1.0
    H = np.eye(row.size) - 2.0 * np.outer(v, v) / (v @ v)
    # H maps e to -sign(e_0) times the first unit vector
    H[:, 0] *= -1.0 if e[0] >= 0.0 else 1.0
    return H
