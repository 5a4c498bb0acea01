"""Whether joints are closed in the initial configuration, and keep what they say beside it.

A constraint Phi that is open at t = 0 would be closed by the first step, with an energy from
nothing. One whose gradient depends there on those of the others, G_r = c G, has no multiplier. It
is redundant if it holds wherever the others do; to second order, for all v with G v = 0,

    v . (Q_r - sum_k c_k Q_k) v = 0

with the second derivatives Q. Else it depends on the others in this one configuration only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.types import Array

LARGEST_PART = 1e-9
"""Maximum gap of a constraint relative to the sum of its terms, which are lengths or cosines ..."""

ROUND_OFF = 1e-14
"""... and relative to the largest vector among the coordinates, where all its terms are zero."""

CURVATURE = 1e-6
"""Round-off of a curvature, relative to its terms."""

ROUND_OFF = 1e-9
"""Factor of a constraint, relative to the largest one, below which it is zero [-]."""


def check_closed(
    constraints: Sequence[Quadratic], owners: Sequence[str], values: Array, q: Array
) -> None:
    """Raise a ModelError for joints that are open.

    Args:
        values: What each of them must be at t = 0, shape (constraints,).
        q: Initial coordinates of all rigid bodies, shape (n_q,).
    """
    gaps = QuadraticMap(constraints, q.size).value(q) - values
    lengths = np.linalg.norm(q.reshape(-1, 3), axis=1)  # of centres and directors
    sizes = np.repeat(lengths, 3)  # a component may be zero up to round-off of the others
    allowed = LARGEST_PART * np.array([_sum_terms(c, sizes) for c in constraints])
    allowed += ROUND_OFF * np.max(lengths, initial=0.0)
    worst: dict[str, int] = {}
    for k in np.flatnonzero(np.abs(gaps) > allowed).tolist():
        best = worst.setdefault(owners[k], k)
        if abs(gaps[k]) > abs(gaps[best]):
            worst[owners[k]] = k
    told = [
        f"{name!r} by {abs(gaps[k]):.3g}{_unit(constraints[k])} (allowed: {allowed[k]:.1g})"
        for name, k in worst.items()
    ]
    if told:
        raise ModelError(
            f"{'these joints are' if len(told) > 1 else 'a joint is'} open in the initial "
            f"configuration, and the first step would snap {'them' if len(told) > 1 else 'it'} "
            f"shut: {', '.join(told)}; move the bodies to where the constraints hold"
        )


def find_singular_rows(
    constraints: Sequence[Quadratic], redundant: npt.NDArray[np.int64], q: Array
) -> list[int]:
    """Those of the redundant constraints that depend on the others in this configuration only.

    Args:
        redundant: Numbers of those that depend on the others.
        q: The configuration, shape (n_q,).
    """
    if not redundant.size:
        return []
    kept = [c for k, c in enumerate(constraints) if k not in redundant]
    functions, rest = (
        QuadraticMap(rows, q.size) for rows in (kept, [constraints[k] for k in redundant])
    )
    G, G_r = functions.jacobian(q), rest.jacobian(q)
    factors = np.linalg.lstsq(G.T, G_r.T, rcond=None)[0].T
    # round-off of zero must not be compared with itself below
    factors[np.abs(factors) < ROUND_OFF * np.abs(factors).max(axis=1, keepdims=True)] = 0.0
    free = np.linalg.svd(G)[2][len(G) :].T  # columns v, G v = 0
    found = []
    for row, k in enumerate(redundant.tolist()):
        Q_r = rest.hessian(np.eye(len(G_r))[row])
        curvature = free.T @ (Q_r - functions.hessian(factors[row])) @ free
        size = np.linalg.norm(Q_r) + np.linalg.norm(functions.hessian(np.abs(factors[row])))
        if np.linalg.norm(curvature) > CURVATURE * size:
            found.append(k)
    return found


def _sum_terms(function: Quadratic, q: Array) -> float:
    """Sum of the absolute values of all terms of a function, for q without negative values."""
    total = abs(function.constant) + sum(abs(b) * q[i] for i, b in function.linear)
    return float(total + sum(abs(a) * q[i] * q[j] for i, j, a in function.bilinear))


def _unit(function: Quadratic) -> str:
    """The unit of a function: that of the centres of mass in it, as directors have none."""
    pairs = [(i,) for i, _ in function.linear] + [(i, j) for i, j, _ in function.bilinear]
    power = max((sum(i % 12 < 3 for i in pair) for pair in pairs), default=0)
    return ("", " m", " m^2")[power]
