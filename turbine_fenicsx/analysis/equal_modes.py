"""Modes of equal eigenvalues, distinguished; the sign or phase of every mode.

Any orthogonal combination of modes with one eigenvalue is as good as another: blades that are
equal, a beam whose section is square, the rigid motions of a free body. Which one a solver finds
depends on round-off and on the number of ranks. The same on any number of them is

- by motions, `choose_basis`: the first vector is the one that moves most at some coordinate, which
  is positive there. The others do not move there, and so on. Of equal blades, each moves alone.
- by features of the motion, `separate_equal_modes`: the first mode of a group has as much of the
  first feature as is possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import FlatVectors
from turbine_fenicsx.analysis.mode import Mode, Modes, Motion
from turbine_fenicsx.foundation.types import Array

EQUAL_TOLERANCE = 1e-6
"""Relative difference of eigenvalues below which they are equal."""

EQUAL_MOTION = 1e-6
"""Maximum relative difference of motions that count as equal; among them position decides."""

MIN_FEATURE_DIFFERENCE = 1e-4
"""Minimum relative difference of the squares of a feature that distinguishes modes."""

FEATURE_ROUND_OFF = 1e-9
"""Square of a feature, relative to those of all features, below which it is round-off."""

T = TypeVar("T")

Features = Sequence[Array]
"""Linear functions of a motion a + i b, real or complex arrays."""


def separate_equal_modes(
    modes: Modes,
    features: Callable[[Mode], Features],
    inner_product: Callable[[Motion, Motion], float],
) -> Modes:
    """Modes that are the same on any number of ranks. Collective.

    Args:
        features: Features of a mode, the most significant one first.
        inner_product: a . M b of two motions.

    Returns: The modes, with equal ones distinguished, and with a sign or phase in which the largest
        entry of the first feature that they have much of is positive.
    """
    found: list[Mode] = []
    for group in group_neighbours(modes.modes, _are_equal):
        seen = [features(mode) for mode in group]
        by_feature = [np.array([np.ravel(f[k]) for f in seen]) for k in range(len(seen[0]))]
        combinations = np.eye(len(group), dtype=by_feature[0].dtype if by_feature else float)
        if len(group) > 1:
            least = FEATURE_ROUND_OFF * sum(float(np.linalg.norm(f)) ** 2 for f in by_feature)
            combinations = _make_orthonormal(_multiply(group, inner_product))
            combinations = _separate(combinations, by_feature, least)
        for mode, weights in zip(group, combinations.T, strict=True):
            turned = weights * _choose_phase([f.T @ weights for f in by_feature])
            found.append(_combine(mode, group, turned))
    modes.destroy()
    return replace(modes, modes=tuple(found))


def group_neighbours(modes: Iterable[T], are_equal: Callable[[T, T], bool]) -> Iterator[list[T]]:
    """Neighbours with equal eigenvalues."""
    group: list[T] = []
    for mode in modes:
        if group and not are_equal(group[-1], mode):
            yield group
            group = []
        group.append(mode)
    if group:
        yield group


def _are_equal(a: Mode, b: Mode) -> bool:
    """Whether two modes have one eigenvalue."""
    if a.is_rigid or b.is_rigid:
        return a.is_rigid and b.is_rigid
    return abs(a.eigenvalue - b.eigenvalue) <= EQUAL_TOLERANCE * abs(a.eigenvalue)


def _multiply(group: Sequence[Mode], inner: Callable[[Motion, Motion], float]) -> Any:
    """Inner products z_i^* . M z_j of modes z = a + i b."""
    is_real = all(mode.imaginary is None for mode in group)
    G = np.zeros((len(group), len(group)), dtype=float if is_real else complex)
    for i, z in enumerate(group):
        for j, w in enumerate(group):
            G[i, j] = inner(z.real, w.real)
            if z.imaginary is not None and w.imaginary is not None:
                G[i, j] += inner(z.imaginary, w.imaginary)
            if w.imaginary is not None:
                G[i, j] += 1j * inner(z.real, w.imaginary)
            if z.imaginary is not None:
                G[i, j] -= 1j * inner(z.imaginary, w.real)
    return G


def _make_orthonormal(G: Any) -> Any:
    """Combinations Q with Q^* G Q = 1, of unit modal mass, as columns."""
    values, vectors = np.linalg.eigh(0.5 * (G + G.conj().T))
    return vectors / np.sqrt(values)


def _separate(Q: Any, by_feature: Sequence[Any], least: float) -> Any:
    """Combinations Q turned among themselves, those with most of the first feature first."""
    if Q.shape[1] == 1 or not by_feature:
        return Q
    F = by_feature[0].T @ Q
    values, vectors = np.linalg.eigh(F.conj().T @ F)
    values, Q = values[::-1], Q @ vectors[:, ::-1]
    starts = 1 + np.flatnonzero(-np.diff(values) > max(MIN_FEATURE_DIFFERENCE * values[0], least))
    pieces = [_separate(piece, by_feature[1:], least) for piece in np.split(Q, starts, axis=1)]
    return np.concatenate(pieces, axis=1)


def _choose_phase(features: Sequence[Any]) -> Any:
    """Factor of a motion: 1 or -1, or exp(i phi) if it has two parts."""
    sizes = np.array([np.linalg.norm(f) for f in features])
    if not np.any(sizes):
        return 1.0
    leading = features[int(np.flatnonzero(sizes > 0.5 * sizes.max())[0])]
    entries = np.abs(leading)
    largest = leading[int(np.flatnonzero(entries > 0.999 * entries.max())[0])]
    return np.conj(largest) / abs(largest)


def _combine(mode: Mode, group: Sequence[Mode], weights: Any) -> Mode:
    """The sum of the modes of a group, with the eigenvalue of one of them."""
    a = [z.real for z in group]
    if all(z.imaginary is None for z in group):
        return replace(mode, real=_add_motions(a, np.real(weights)))
    b = [z.imaginary or z.real for z in group]  # with the weight 0 where there is none
    has = np.array([z.imaginary is not None for z in group])
    both, real, imaginary = [*a, *b], np.real(weights), np.imag(weights)
    return replace(
        mode,
        real=_add_motions(both, np.concatenate([real, -imaginary * has])),
        imaginary=_add_motions(both, np.concatenate([imaginary, real * has])),
    )


def _add_motions(motions: Sequence[Motion], weights: Array) -> Motion:
    """A sum of motions with weights, in new vectors."""
    u: list[PETSc.Vec] = []
    for vectors in zip(*(m.u for m in motions), strict=True):
        total = vectors[0].duplicate()
        total.set(0.0)
        for weight, vector in zip(weights, vectors, strict=True):
            total.axpy(float(weight), vector)
        u.append(total)
    return Motion(
        sum((w * m.q for w, m in zip(weights, motions, strict=True)), np.zeros_like(motions[0].q)),
        sum(
            (w * m.joint_coordinates for w, m in zip(weights, motions, strict=True)),
            np.zeros_like(motions[0].joint_coordinates),
        ),
        tuple(u),
    )


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
    chosen = np.flatnonzero(lengths >= (1.0 - EQUAL_MOTION) * longest)
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
