"""The matrix of first order of motions and air, and its eigenvalues."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eig

from turbine_fenicsx.analysis.air_terms import AirTerms
from turbine_fenicsx.foundation.types import Array

TURNS = 0.5
"""Part of the modal mass of a motion from which on it is the rotation of a free rotor."""

SPEED_PART = 0.5
"""Share of the speed, over the largest one, from which on a mode is one of the speed."""

STRUCTURAL = 0.4
"""Least share of motions in a mode of the structure; the rest are motions of the air."""


def assemble(D: Array, K: Array, terms: list[AirTerms]) -> Array:
    """The matrix of first order."""
    m, sizes = len(K), [len(t.models) for t in terms]
    A = np.zeros((2 * m + sum(sizes),) * 2)
    a, rate = slice(0, m), slice(m, 2 * m)
    A[a, rate], A[rate, a], A[rate, rate] = np.eye(m), -K, -D
    for t, end in zip(terms, 2 * m + np.cumsum(sizes), strict=True):
        states = slice(end - len(t.models), end)
        A[rate, a] += t.by_motion
        A[rate, rate] += t.by_rate
        A[rate, states] = t.by_states
        A[states, a], A[states, rate] = t.rates_by_motion, t.rates_by_rate
        A[states, states] = t.rates_by_states + t.whirl
    return A


def solve_first_order(A: Array, rotation: Array, with_speed: bool) -> tuple[Array, Array]:
    """Eigenvalues of the structure by rising size, one of each pair, and their vectors, (n, k).

    Args:
        rotation: The rotation of what turns, of unit modal mass, shape (m,).
        with_speed: Whether the one of the speed of the rotor is added after them. Several may have
            much of the speed; of these the one of the highest frequency.
    """
    m = len(rotation)
    values, left, right = eig(A, left=True, right=True)
    products = left.conj() * right
    of_motions = np.abs(products[: 2 * m].sum(axis=0) / products.sum(axis=0))
    a = right[:m]
    turns = np.abs(rotation @ a) ** 2 > TURNS * np.sum(np.abs(a) ** 2, axis=0)
    numbers = np.flatnonzero((of_motions >= STRUCTURAL) & (values.imag >= 0.0) & ~turns)
    numbers = numbers[np.argsort(np.abs(values[numbers]))]
    if with_speed:
        rate = slice(m, 2 * m)
        shares = np.abs((rotation @ left[rate].conj()) * (rotation @ right[rate]))
        shares = np.where(values.imag >= 0.0, shares / np.abs(products.sum(axis=0)), 0.0)
        has_speed = shares >= SPEED_PART * np.max(shares)
        numbers = np.append(numbers, np.argmax(np.where(has_speed, values.imag, -1.0)))
    return values[numbers], right[:, numbers]
