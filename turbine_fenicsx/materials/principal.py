"""Principal stretches, for laws in terms of them such as Ogden's."""

from __future__ import annotations

from math import sqrt

import ufl
from ufl.core.expr import Expr

EQUAL = 1e-12
"""Addition to the square p^2 of the radius below, so that equal stretches have derivatives."""

ENDS = 1e-10
"""Part by which the cosine of the angle stays away from -1 and 1."""


def squared_stretches(C: Expr) -> tuple[Expr, Expr, Expr]:
    """Eigenvalues of C, the squares of the principal stretches, as UFL expressions.

    With q = tr C/3 and B = C - q I, p^2 = B:B/6 and cos 3 phi = det B/(2 p^3), 0 <= phi <= pi/3,
    they are

        q + 2 p cos phi,    q + 2 p cos(phi +- 2 pi/3).

    Where two or three are equal, these formulas have no derivatives. p^2 is larger by 1e-12 here,
    and cos 3 phi smaller by a part of 1e-10, so that equal stretches differ by some 1e-6. An energy
    that is the same in all three changes by the square of that, and steps conserve the changed one.
    C counts by its upper triangle.

    Args:
        C: Right Cauchy-Green tensor, a UFL tensor of shape (3, 3).

    Returns:
        The largest, the least, and the middle one.
    """
    q = ufl.tr(C) / 3.0
    a, b, c = (C[i, i] - q for i in range(3))
    d, e, f = C[1, 2], C[0, 2], C[0, 1]
    p2 = (a * a + b * b + c * c) / 6.0 + (d * d + e * e + f * f) / 3.0 + EQUAL
    p = ufl.sqrt(p2)
    half_det = 0.5 * (a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e))
    phi = ufl.acos((1.0 - ENDS) * half_det / (p2 * p)) / 3.0
    x, y = p * ufl.cos(phi), sqrt(3.0) * p * ufl.sin(phi)
    return q + 2.0 * x, q - x - y, q - x + y
