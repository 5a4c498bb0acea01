"""Lagrange polynomials through points on a line, and two rules of quadrature."""

from __future__ import annotations

import numpy as np
from scipy.special import eval_legendre, roots_jacobi, roots_legendre

from turbine_fenicsx.foundation.types import Array


def lagrange(points: Array, x: Array) -> Array:
    """Polynomials that are one at a point and zero at the others.

    Args:
        points: Shape (..., p).
        x: Shape (...,).

    Returns:
        Values at x, shape (..., p).
    """
    found = np.ones((*np.shape(x), points.shape[-1]))
    for i in range(points.shape[-1]):
        for j in (j for j in range(points.shape[-1]) if j != i):
            found[..., i] *= (x - points[..., j]) / (points[..., i] - points[..., j])
    return found


def lagrange_slopes(points: Array) -> Array:
    """Derivatives of the polynomials at the points themselves, shape (p, p), point by row."""
    gaps = points[:, None] - points + np.eye(len(points))
    weights = 1.0 / np.prod(gaps, axis=1)
    slopes: Array = weights / (weights[:, None] * gaps)
    np.fill_diagonal(slopes, 0.0)
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    return slopes


def gauss_rule(number: int) -> tuple[Array, Array]:
    """Gauss points and weights between 0 and 1, exact for polynomials of the degree 2 n - 1."""
    x, w = roots_legendre(number)
    return 0.5 * (x + 1.0), 0.5 * w


def lobatto_rule(number: int) -> tuple[Array, Array]:
    """Points and weights with both ends of 0 to 1, exact for the degree 2 n - 3."""
    inner = roots_jacobi(number - 2, 1.0, 1.0)[0] if number > 2 else []
    x = np.concatenate([[-1.0], inner, [1.0]])
    w = 2.0 / (number * (number - 1) * eval_legendre(number - 1, x) ** 2)
    return 0.5 * (x + 1.0), 0.5 * w
