"""Points of a wall at which its energy is sampled: few around the section, or it locks.

A section that becomes oval bends its walls without stretching them. A curved cell of the second
degree can do so at two Gauss points around the section, but not at three. The strain that is left
there is small, but a thin wall is many times stiffer in stretching than in bending. Three points
along the span leave no motion but the rigid ones without energy. Strongly curved cells still have
motions with very little of it, outwards at the ends of a cell and inwards in its middle;
`STABILISING` gives the middle a little weight against them. Through the wall both faces and the
middle are sampled (Lobatto), because the stiffness there that gives A, B and D of a laminate is
then not negative.

Clamped tube of the length 10 R and the thickness R/75, pulled oval at its free end, 16 cells along
the span: error of the deflection with 8, 16 and 24 cells around. Free tube of the length 6 R, a
sandwich of R/50: frequency of the softest such motion with 6 cells around, whose lowest true
frequency is 11.0 Hz::

    points (span, around, through)                      deflection         motion    points
    3, 3, 3                                         -97, -80, -50  %                     27
    98 % of 2, 2, 2 and 2 % of 3, 3, 3              -62, -11,  -3  %                     35
    3, 2, 3                                          -2,  -1,  -1  %         2 Hz        18
    99.95 % of 3, 2, 3 and 0.05 % of 3, 1, 1 (used)  -8,  -1,  -1  %        31 Hz        21
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Quadrature

STABILISING = 5e-4
"""Share of the points in the middle of the cells, around the section and through the wall."""

FACE_WEIGHT = (1.0 - STABILISING) / 6.0
"""Weight of all points at one face of the wall."""

MIDDLE_WEIGHT = 1.0 - 2.0 * FACE_WEIGHT
"""Weight of all points in the middle between the faces."""

_leggauss: Callable[[int], tuple[Array, Array]] = np.polynomial.legendre.leggauss
_LOBATTO = np.array([-1.0, 0.0, 1.0]), np.array([1.0, 4.0, 1.0]) / 3.0


def gauss_quadrature(span: int, around: int, through: int) -> Quadrature:
    """Gauss points along each axis of the unit cube."""
    return _multiply([_leggauss(n) for n in (span, around, through)])


def wall_quadrature() -> Quadrature:
    """Points and weights on the unit cube: span, around the section, through the wall."""
    main = _multiply([_leggauss(3), _leggauss(2), _LOBATTO])
    more = gauss_quadrature(3, 1, 1)
    return Quadrature(
        np.concatenate([main.points, more.points]),
        np.concatenate([(1.0 - STABILISING) * main.weights, STABILISING * more.weights]),
    )


def _multiply(rules: Sequence[tuple[Array, Array]]) -> Quadrature:
    """The rule on the unit cube of three rules on the interval from -1 to 1."""
    axes = np.meshgrid(*(0.5 + 0.5 * points for points, _ in rules), indexing="ij")
    weights: Array = np.einsum("i,j,k->ijk", *(0.5 * weights for _, weights in rules))
    return Quadrature(np.stack([x.ravel() for x in axes], axis=1), weights.ravel())
