"""Quadratic functions of rigid-body coordinates, their Jacobians and exact discrete gradients.

All constraints between rigid bodies, and the cosine and sine of joint angles, are built from dot
products of directors and joint points. Directors and points are *affine* in the coordinates, so
each such function is

    Phi(q) = c + b . q + q . Q q / 2,          grad Phi(q) = b + Q q,

and its discrete gradient is the Jacobian at the midpoint (Gonzalez 1996), exactly:

    grad Phi((q_n + q_{n+1})/2) . (q_{n+1} - q_n) = Phi(q_{n+1}) - Phi(q_n).

Joints state their functions with `AffineVector` and `dot`; `QuadraticMap` evaluates all of them
together, with a handful of numpy calls whatever the number of joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True)
class AffineVector:
    """A vector of R^3 that is affine in the coordinates: v = v0 + sum_k a_k y_k.

    The coordinates are read as a list of 3-vectors y_k ("slots"): the centre of mass and the
    three directors of each rigid body, in this order.
    """

    constant: tuple[float, float, float]
    terms: tuple[tuple[int, float], ...] = ()

    @staticmethod
    def fixed(vector: npt.ArrayLike) -> AffineVector:
        """The vector fixed in space with the given components, shape (3,)."""
        x, y, z = (float(c) for c in np.asarray(vector, dtype=float))
        return AffineVector((x, y, z))

    @staticmethod
    def slot(index: int) -> AffineVector:
        """The coordinate 3-vector number ``index`` itself."""
        return AffineVector((0.0, 0.0, 0.0), ((index, 1.0),))

    def __add__(self, other: AffineVector) -> AffineVector:
        constant = np.add(self.constant, other.constant)
        coefficients = dict(self.terms)
        for k, a in other.terms:
            coefficients[k] = coefficients.get(k, 0.0) + a
        return AffineVector(tuple(constant.tolist()), tuple(coefficients.items()))

    def __mul__(self, factor: float) -> AffineVector:
        constant = tuple((factor * np.asarray(self.constant)).tolist())
        return AffineVector(constant, tuple((k, factor * a) for k, a in self.terms))

    __rmul__ = __mul__

    def __sub__(self, other: AffineVector) -> AffineVector:
        return self + (-1.0) * other

    def components(self) -> tuple[Quadratic, Quadratic, Quadratic]:
        """The three components along e1, e2, e3, as (linear) functions."""
        e1, e2, e3 = (AffineVector.fixed(e) for e in np.eye(3))
        return dot(self, e1), dot(self, e2), dot(self, e3)


@dataclass(frozen=True)
class Quadratic:
    """A scalar function c + sum b_i q_i + sum_{ij} a_ij q_i q_j of the coordinates."""

    constant: float
    linear: tuple[tuple[int, float], ...] = ()
    bilinear: tuple[tuple[int, int, float], ...] = ()

    def __add__(self, other: Quadratic | float) -> Quadratic:
        """Sum with another function or a number."""
        if not isinstance(other, Quadratic):
            other = Quadratic(float(other))
        return Quadratic(
            self.constant + other.constant,
            self.linear + other.linear,
            self.bilinear + other.bilinear,
        )

    def __mul__(self, factor: float) -> Quadratic:
        return Quadratic(
            factor * self.constant,
            tuple((i, factor * b) for i, b in self.linear),
            tuple((i, j, factor * a) for i, j, a in self.bilinear),
        )

    __rmul__ = __mul__

    def __sub__(self, other: Quadratic | float) -> Quadratic:
        """Difference with another function or a number."""
        return self + (-1.0) * other


def dot(v: AffineVector, w: AffineVector) -> Quadratic:
    """Scalar product of two affine vectors, a quadratic function."""
    linear, bilinear = [], []
    for c in range(3):
        linear += [(3 * k + c, a * w.constant[c]) for k, a in v.terms if w.constant[c]]
        linear += [(3 * k + c, a * v.constant[c]) for k, a in w.terms if v.constant[c]]
        bilinear += [(3 * k + c, 3 * m + c, a * b) for k, a in v.terms for m, b in w.terms]
    return Quadratic(float(np.dot(v.constant, w.constant)), tuple(linear), tuple(bilinear))


class QuadraticMap:
    """Several quadratic functions of the same coordinates, evaluated together.

    Args:
        functions: The rows Phi_k.
        size: Number of coordinates.

    Attributes:
        constant: The constants c, shape (rows,).
    """

    def __init__(self, functions: Sequence[Quadratic], size: int) -> None:
        self.shape = (len(functions), size)
        self.constant = np.array([f.constant for f in functions], dtype=float)
        self._b = np.zeros(self.shape)
        entries: dict[tuple[int, int, int], float] = {}
        for k, f in enumerate(functions):
            for i, b in f.linear:
                self._b[k, i] += b
            for i, j, a in f.bilinear:
                for key in ((k, i, j), (k, j, i)):
                    entries[key] = entries.get(key, 0.0) + a
        index = np.array(list(entries), dtype=np.int64).reshape(-1, 3)
        self._k, self._i, self._j = index.T
        self._a = np.fromiter(entries.values(), dtype=float, count=len(entries))
        self._flat_ki = self._k * size + self._i
        self._flat_ij = self._i * size + self._j

    def jacobian(self, q: Array) -> Array:
        """Jacobian b + Q q, shape (rows, size)."""
        Qq = np.bincount(self._flat_ki, self._a * q[self._j], minlength=self._b.size)
        return self._b + Qq.reshape(self.shape)

    def value(self, q: Array, jacobian: Array | None = None) -> Array:
        """Values Phi_k(q), shape (rows,); give the Jacobian at q if it is known already."""
        G = self.jacobian(q) if jacobian is None else jacobian
        Phi: Array = self.constant + 0.5 * ((self._b + G) @ q)
        return Phi

    def hessian(self, weights: Array) -> Array:
        """sum_k weights_k Q_k, shape (size, size)."""
        size = self.shape[1]
        Q = np.bincount(self._flat_ij, self._a * weights[self._k], minlength=size * size)
        return np.asarray(Q, dtype=float).reshape(size, size)
