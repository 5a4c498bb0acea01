"""Loads of long return periods from runs of minutes, by Gumbel's distribution of block maxima.

The largest values of blocks of duration T_b at the wind speed k have the distribution

    F_k(x) = exp(-exp(-(x - mu_k)/beta_k)),   beta_k = l_2/ln 2,   mu_k = l_1 - gamma beta_k,

where l_1, l_2 are the first L-moments of those that were seen and gamma is Euler's constant. With
the probability p_k of the winds of a speed, ten minutes have a larger value with the probability

    P(x) = sum_k p_k (1 - F_k(x)^n),   n = 600 s/T_b,

and the load of a return period T is where P(x) = 600 s/T (IEC 61400-1, annex on extrapolation).
Confidence is that of a parametric bootstrap, samples of the distributions that were found. Drawing
the blocks again instead encloses the load in 8 of 10 cases in place of 9, and in 7 of few blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array

TEN_MINUTES = 600.0
"""Time of the standard's probabilities [s]."""

CONFIDENCE, SAMPLES, SEED = 0.9, 300, 1
"""Probability that the limits enclose a load; number of bootstrap samples and their seed."""

_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """Loads of a return period, arrays of shape (n,).

    Args:
        loads: Most probable ones.
        low: Lower limits of confidence.
        high: Upper limits.
    """

    loads: Array
    low: Array
    high: Array


def extrapolate(
    blocks: Sequence[Array], shares: Sequence[float], duration: float, periods: Sequence[float]
) -> list[Extrapolation]:
    """Largest loads of return periods; the least of x are the largest of -x.

    Args:
        blocks: Largest values of the blocks at each wind speed, shape (blocks, n), two at least.
        shares: Probability of the winds of each speed; their sum is 1.
        duration: Of a block [s].
        periods: Return periods, longer than ten minutes [s].
    """
    random, fits = np.random.default_rng(SEED), []
    for values in blocks:
        mu_k, beta_k = _fit(values)
        # the fit follows origin and unit, so that samples of the standard distribution serve all
        zero, one = _fit(random.gumbel(size=(len(values), SAMPLES)))
        shift, factor = (np.append(x, y)[:, None] for x, y in ((0.0, zero), (1.0, one)))
        fits.append((mu_k + beta_k * shift, beta_k * factor))
    # shape of both: (1 + samples, n, speeds); the loads themselves stand before the samples
    mu, beta = (np.stack(parameter, axis=-1) for parameter in zip(*fits, strict=True))
    side = 0.5 * (1.0 - CONFIDENCE)
    found = []
    for period in periods:
        every = _solve(mu, beta, np.array(shares), TEN_MINUTES / duration, TEN_MINUTES / period)
        low, high = np.quantile(every[1:], [side, 1.0 - side], axis=0)
        found.append(Extrapolation(every[0], low, high))
    return found


# beta_k = l_2/ln 2,  mu_k = l_1 - gamma beta_k
def _fit(values: Array) -> tuple[Array, Array]:
    """Gumbel's parameters of samples that lie along the first axis."""
    ordered = np.sort(values, axis=0)
    m = len(ordered)
    weights = (2.0 * np.arange(m) / (m - 1) - 1.0) / m
    beta = np.tensordot(weights, ordered, axes=1) / np.log(2.0)
    return ordered.mean(axis=0) - np.euler_gamma * beta, beta


# P(x) = sum_k p_k (1 - F_k(x)^n)
def _solve(mu: Array, beta: Array, shares: Array, n: float, probability: float) -> Array:
    """Loads that ten minutes exceed with a probability.

    Args:
        mu: Parameters, speeds along the last axis.
        shares: Of the speeds.
    """
    beta = np.maximum(beta, np.finfo(float).tiny)
    # one speed alone has P = p_k (1 - F_k^n), and all together less than sum_k p_k n (1 - F_k)
    enough = shares > probability
    alone = -np.log1p(-probability / shares[enough]) / n
    low = (mu[..., enough] - beta[..., enough] * np.log(alone)).max(axis=-1)
    high = (mu + beta * np.log(n * shares.sum() / probability)).max(axis=-1)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        with np.errstate(over="ignore"):  # of columns that rest
            rest = np.exp(np.clip((mu - middle[..., None]) / beta, -700.0, 700.0))
        larger = -np.expm1(-n * rest) @ shares > probability
        low, high = np.where(larger, middle, low), np.where(larger, high, middle)
    return np.asarray(high)
