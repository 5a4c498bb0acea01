"""Peel and shear stress of adhesive bonds at the edges of walls, an estimate.

A wall ends in a bond of width b. Its forces and moment per length there, from the strains of both
faces by lamination theory, load an adhesive of thickness t_a, which is a foundation of the
stiffness k = E_a/t_a per area. With 1/l = (k/(4 D22))^(1/4) of the wall on it, the foot of a web,
bonded in its middle, has

    peel = N22 max(1/b, 1/(2 l)) +- M22 max(6/b^2, c/l^2),    c = exp(-pi/4)/sqrt(2),

where the first numbers are those of a stiff foot, and the second ones those of a soft one
(infinite beam on its foundation, M. Hetenyi 1946). At a trailing edge two walls peel each other:
for each the foundation is twice as stiff, and its moment stands at the end of the bond,

    peel = +- M22 max(6/b^2, 2/l^2).

Shear flows through the bond as through a lap joint of two such walls (O. Volkersen 1938),

    shear = N12/b x coth(x),    x = b/2 sqrt(2 G_a/(t_a A66)).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, pi, sqrt, tanh

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.laminate_theory import Plies, laminate_stiffness, total_thickness

SOFT = exp(-0.25 * pi) / sqrt(2.0)
"""Largest pressure below a moment in the middle of a long beam on a foundation, times l^2/M."""


@dataclass(frozen=True)
class Adhesive:
    """An adhesive between two walls.

    Args:
        thickness: Its thickness [m].
        width: Width of the bond [m].
        young: Young's modulus [Pa].
        shear: Shear modulus [Pa].

    Raises:
        ModelError: for numbers that are not positive.
    """

    thickness: float
    width: float
    young: float
    shear: float

    def __post_init__(self) -> None:
        if not all(0.0 < x < inf for x in (self.thickness, self.width, self.young, self.shear)):
            raise ModelError(f"thickness, width and moduli of an adhesive must be positive: {self}")


def find_bond_stresses(plies: Plies, is_edge: bool, adhesive: Adhesive) -> Array:
    """Peel and shear at both sides of a bond by the strains of its wall.

    Args:
        plies: Of the wall.
        is_edge: Whether two walls meet there, at a trailing edge, or a web stands on its foot.
        adhesive: The adhesive.

    Returns:
        Shape (2, 3, 6) [Pa]: sides of the bond; nothing, peel and shear; strains 11, 22, 12 of the
        inner face, then of the outer one.
    """
    A, B, D = laminate_stiffness(plies)
    half, slope = 0.5 * np.eye(3), np.eye(3) / total_thickness(plies)
    # e = (inner + outer)/2, k = (outer - inner)/h
    strains = np.block([[half, half], [-slope, slope]])
    (_, N22, N12), (_, M22, _) = np.hstack([A, B]) @ strains, np.hstack([B, D]) @ strains
    b, k = adhesive.width, adhesive.young / adhesive.thickness
    x = 0.5 * b * sqrt(2.0 * adhesive.shear / (adhesive.thickness * float(A[2, 2])))
    shear = N12 / b * x / tanh(x)
    square = sqrt((2.0 if is_edge else 1.0) * k / (4.0 * float(D[1, 1])))  # 1/l^2
    if is_edge:
        force, moment = np.zeros(6), M22 * max(6.0 / b**2, 2.0 * square)
    else:
        force, moment = N22 * max(1.0 / b, 0.5 * sqrt(square)), M22 * max(6.0 / b**2, SOFT * square)
    return np.array([[np.zeros(6), force + sign * moment, shear] for sign in (1.0, -1.0)])
