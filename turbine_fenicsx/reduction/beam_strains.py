"""Strain energy and mass of a beam as a basis needs them.

With the axis r(s), the directors d_1(s), d_2(s) of its section, ' = d/ds and the values tau_0,
kappa_10, kappa_20 at rest, the strains are what these have beyond rest:

    Gamma_1 = r'.d_1,    Gamma_2 = r'.d_2,    eps = (r'.r' - 1)/2,
    kappa_1 =  r'.d_2' + tau_0 Gamma_1 - kappa_10 eps,
    kappa_2 = -r'.d_1' + tau_0 Gamma_2 - kappa_20 eps,
    kappa_3 = (d_1'.d_2 - d_1.d_2')/2.

They are linear in scalar products of vectors, and Reissner's to first order. In each element they
are polynomials through their values e at p Gauss points, so that no strain locks, and

    U = 1/2 e.H e,    H = int phi_g phi_h C ds,    H = V V^T,    c = V^T e,

is exact for stiffness C straight between stations. The resultants F, M at Gauss point g are the
derivative of U with respect to e_g over its weight. Viscosity makes V a matrix for which the
damping sqrt(t_i t_j) H_ij is V diag(Z) V^T.

Sections stay whole by three more strains at each node, of the stiffness hold EA h, with the length
h that the node stands for:

    (d_1.d_1 - 1)/2,    (d_2.d_2 - 1)/2,    d_1.d_2.

Moments M shorten directors, for U falls with them. So curvatures grow by the part M kappa/(hold EA)
of themselves, the square of the bending strain at a radius of inertia over hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.lagrange import gauss_rule, lagrange
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_elements import BeamElements
from turbine_fenicsx.reduction.beam_sections import BeamSections


class StrainFactors(NamedTuple):
    """Strain energy of a beam.

    Attributes:
        strain_factor: W, shape (pairs, r).
        viscosity: Z, shape (r,) [s]; shape (0,) without.
        stations: Arc lengths of the Gauss points, shape (g,) [m].
        section_factor: Q with the resultants Q c, shape (6 g, r).
        section_rows: r', d_1, d_2, d_1', d_2' there as sums of y, shape (5 g, m).
    """

    strain_factor: Array
    viscosity: Array
    stations: Array
    section_factor: Array
    section_rows: Array


@dataclass(frozen=True, eq=False)
class BeamMotion:
    """How vectors y move the nodes of a beam.

    Args:
        rows: Axis (less the first point) and both directors of each node as sums of y, shape
            (3, K + 1, m).
        at_rest: y at rest, shape (m, 3).
    """

    rows: Array
    at_rest: Array


def find_strain_factors(
    elements: BeamElements, sections: BeamSections, motion: BeamMotion, hold: float
) -> StrainFactors:
    """Strain energy of a beam in scalar products of its vectors.

    Args:
        hold: Stiffness that keeps sections whole, over that of stretch.
    """
    times = np.asarray(sections.viscosity)
    factors, lost, stations, forces, every = [], [], [], [], []
    gauss, weights = gauss_rule(elements.degree)
    for e in range(elements.number):
        first, last = elements.ends[e : e + 2]
        s = first + (last - first) * gauss
        rows = _find_rows(elements, motion, e, s)
        strains = np.concatenate([_strains_at(each, motion.at_rest) for each in rows])
        V, Z = _split(_integrate_stiffness(sections, s, first, last), times)
        factors.append(strains.T @ V)
        forces.append(V / np.repeat(weights * (last - first), 6)[:, None])
        lost.append(Z)
        stations.append(s)
        every.append(rows)
    holds = np.sqrt(hold) * _hold_sections(elements, sections, motion)
    W = np.concatenate([*factors, holds], axis=1)
    Q = np.zeros((6 * elements.number * elements.degree, W.shape[1]))
    k = 6 * elements.degree
    for e, block in enumerate(forces):
        Q[e * k : e * k + k, e * k : e * k + k] = block
    Z = np.concatenate([*lost, np.full(holds.shape[1], times.mean())])
    by_kind = np.concatenate(every).swapaxes(0, 1)
    return StrainFactors(
        strain_factor=W,
        viscosity=Z if times.any() else np.zeros(0),
        stations=np.concatenate(stations),
        section_factor=Q,
        section_rows=by_kind.reshape(-1, by_kind.shape[2]),
    )


def find_mass(elements: BeamElements, sections: BeamSections, rows: Array) -> Array:
    """M = int rho F_k F_l dV of the functions of a basis, shape (n, n) [kg].

    Args:
        rows: Axis and directors of each node as sums of all vectors, shape (3, K + 1, n).
    """
    found = np.zeros((rows.shape[2],) * 2)
    for e in range(elements.number):
        nodes = elements.nodes_of(e)
        s, weights = _rule_between(elements.ends[e : e + 2], sections.stations, elements.degree + 1)
        N, _ = elements.functions(e, s)
        at = np.tensordot(N, rows[:, nodes], (1, 1))  # (q, 3, n)
        A = weights[:, None, None] * sections.moments_at(s)
        found += np.tensordot(at, A @ at, ((0, 1), (0, 1)))
    return 0.5 * (found + found.T)


def _find_rows(elements: BeamElements, motion: BeamMotion, e: int, s: Array) -> Array:
    """r', d_1, d_2, d_1', d_2' of an element at arc lengths as sums of y, shape (k, 5, m).

    Interpolated directors are shorter than 1, and so are slopes of an interpolated axis.
    """
    N, D = elements.functions(e, s)
    axis, *directors = motion.rows[:, elements.nodes_of(e)]
    slope = D @ axis
    speed = _lengths(slope, motion)
    d = [N @ rows for rows in directors]
    lengths = [_lengths(rows, motion) for rows in d]
    bent = [D @ rows / (speed * length) for rows, length in zip(directors, lengths, strict=True)]
    units = [rows / length for rows, length in zip(d, lengths, strict=True)]
    return np.stack([slope / speed, *units, *bent], axis=1)


def _lengths(rows: Array, motion: BeamMotion) -> Array:
    """Lengths at rest of sums of y, shape (k, 1)."""
    found: Array = np.linalg.norm(rows @ motion.at_rest, axis=1)[:, None]
    return found


def _strains_at(rows: Array, at_rest: Array) -> Array:
    """Strains at a point, with r', d_1, d_2, d_1', d_2' as sums of y, shape (6, pairs)."""
    r, d1, d2, e1, e2 = rows
    X = rows @ at_rest
    tau = 0.5 * (X[3] @ X[2] - X[1] @ X[4])
    kappa_1, kappa_2 = X[0] @ X[4], -X[0] @ X[3]
    shear_1, shear_2, stretch = pair_rows(r, d1), pair_rows(r, d2), 0.5 * pair_rows(r, r)
    return np.stack(
        [
            shear_1,
            shear_2,
            stretch,
            pair_rows(r, e2) + tau * shear_1 - kappa_1 * stretch,
            -pair_rows(r, e1) + tau * shear_2 - kappa_2 * stretch,
            0.5 * (pair_rows(e1, d2) - pair_rows(d1, e2)),
        ]
    )


def pair_rows(a: Array, b: Array) -> Array:
    """The scalar product of two sums of vectors as a sum of products of pairs, shape (pairs,)."""
    first, second = np.triu_indices(len(a))
    found: Array = a[first] * b[second]
    found += np.where(first == second, 0.0, a[second] * b[first])
    return found


def _integrate_stiffness(sections: BeamSections, gauss: Array, first: float, last: float) -> Array:
    """H of an element, shape (6 p, 6 p)."""
    p = len(gauss)
    s, weights = _rule_between(np.array([first, last]), sections.stations, p)
    phi = lagrange(gauss, s)
    C = sections.stiffness_at(s)
    H = np.einsum("q,qg,qh,qij->gihj", weights, phi, phi, C, optimize=True)
    return np.asarray(H.reshape(6 * p, 6 * p))


def _split(H: Array, times: Array) -> tuple[Array, Array]:
    """V with H = V V^T, and Z of the damping matrix in these, both of an element."""
    V = np.linalg.cholesky(H)
    if np.ptp(times) == 0.0:
        return V, np.full(len(H), times[0])
    root = np.tile(np.sqrt(times), len(H) // 6)
    half = np.linalg.solve(V, root[:, None] * V)  # V^-1 D V^-T = half half^T
    Z, turn = np.linalg.eigh(half @ half.T)
    return V @ turn, np.maximum(Z, 0.0)


def _hold_sections(elements: BeamElements, sections: BeamSections, motion: BeamMotion) -> Array:
    """Columns of W that keep the sections at the nodes whole, for hold = 1, (pairs, 3 (K + 1))."""
    stretch = sections.stiffness_at(elements.node_places)[:, 2, 2]
    columns = []
    for k, (EA, h) in enumerate(zip(stretch, elements.node_lengths, strict=True)):
        d1, d2 = motion.rows[1, k], motion.rows[2, k]
        root = np.sqrt(EA * h)
        strains = 0.5 * pair_rows(d1, d1), 0.5 * pair_rows(d2, d2), pair_rows(d1, d2)
        columns += [root * strain for strain in strains]
    return np.array(columns).T


def _rule_between(ends: Array, stations: Array, points: int) -> tuple[Array, Array]:
    """Gauss points and weights on each piece between two arc lengths that has no station inside."""
    first, last = ends
    inner = stations[(stations > first) & (stations < last)]
    breaks = np.concatenate([[first], inner, [last]])
    x, w = gauss_rule(points)
    lengths = np.diff(breaks)[:, None]
    return (breaks[:-1, None] + lengths * x).ravel(), (lengths * w).ravel()
