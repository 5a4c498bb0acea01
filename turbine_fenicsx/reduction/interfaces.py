"""Surfaces that couplings hold, and the functions that move with them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse.linalg import splu

from turbine_fenicsx.foundation.rotations import skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.gathered_body import WholeBody


def find_origins(whole: WholeBody, surfaces: Sequence[IntArray]) -> Array:
    """X_s, the middle of the nodes of each surface, shape (S, 3); of the body if there is none."""
    if not surfaces:
        masses = whole.mass.diagonal()
        return np.asarray(masses @ whole.positions / masses.sum())[None]
    return np.array([whole.positions[nodes].mean(axis=0) for nodes in surfaces])


def make_interface_functions(
    whole: WholeBody, surfaces: Sequence[IntArray], origins: Array
) -> Array:
    """f_s and f_s (X - X_s)_j at all nodes, shape (N, 4 S); f_s are harmonic.

    Args:
        whole: The body; its Laplacian counts from two surfaces on.
        origins: X_s, shape (S, 3).
    """
    f = np.ones((len(whole.positions), 1))
    if len(surfaces) > 1:
        held = np.concatenate(surfaces)
        free = np.setdiff1d(np.arange(len(f)), held)
        f = np.zeros((len(f), len(surfaces)))
        for s, nodes in enumerate(surfaces):
            f[nodes, s] = 1.0
        assert whole.laplacian is not None
        rows = whole.laplacian[free]
        f[free] = -splu(rows[:, free].tocsc()).solve(np.asarray(rows[:, held] @ f[held]))
        f[:, 0] = 1.0 - f[:, 1:].sum(axis=1)  # affine motions to the last digit
    columns = []
    for s, origin in enumerate(origins):
        arms = whole.positions - origin
        columns += [f[:, s], *(f[:, s] * arm for arm in arms.T)]
    return np.column_stack(columns)


def rigid_motions(positions: Array, origin: Array) -> Array:
    """Three displacements and three rotations about a point, shape (6, N, 3)."""
    n = len(positions)
    shifts = np.broadcast_to(np.eye(3)[:, None], (3, n, 3))
    turns = -skew_rows(positions - origin).transpose(2, 0, 1)
    return np.concatenate([shifts, turns])
