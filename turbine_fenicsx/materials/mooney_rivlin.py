"""Compressible Mooney-Rivlin material, for rubber."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.materials.cell_fields import Scalar, check_cells


@dataclass(frozen=True)
class MooneyRivlin:
    """W = c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + kappa/4 (J^2 - 1 - 2 ln J).

    I1 = tr C, I2 = (I1^2 - tr C^2)/2 and J = sqrt(det C). The shear modulus at rest is 2 (c10 +
    c01). The last term is convex in J and grows without bound for J -> 0 and J -> infinity. With
    kappa/2 (J - 1)^2 a cell could collapse for a finite energy; kappa/2 (ln J)^2 is not convex
    beyond J = e (Doll and Schweizerhof 2000).

    Args:
        c10: Factor of the first invariant [Pa], not negative.
        c01: Factor of the second invariant [Pa], not negative; zero for neo-Hookean rubber.
            Either of the two must be positive. (Negative factors, which some fits give, make the
            energy fall without bound in large stretches.)
        bulk_modulus: kappa [Pa], positive. Where it is a hundred times the shear modulus or more,
            trilinear hexahedra and linear tetrahedra lock; take quadratic ones.

    Each is a number or a `cell_field`.

    Raises:
        ModelError: if the energy is not positive definite.
    """

    c10: Scalar
    c01: Scalar
    bulk_modulus: Scalar
    quadratic = False

    def __post_init__(self) -> None:
        check_cells(
            "material is not positive definite: c10 = {c10} Pa and c01 = {c01} Pa must not be "
            "negative, nor both zero",
            lambda a, b: (a >= 0.0) & (b >= 0.0) & (a + b > 0.0) & (a + b < np.inf),
            c10=self.c10,
            c01=self.c01,
        )
        check_cells(
            "material is not positive definite: bulk modulus {bulk_modulus} Pa",
            lambda kappa: (kappa > 0.0) & (kappa < np.inf),
            bulk_modulus=self.bulk_modulus,
        )

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        c10, c01, kappa = (parameter(c) for c in (self.c10, self.c01, self.bulk_modulus))
        J2 = ufl.det(C)
        I1 = ufl.tr(C)
        I2 = 0.5 * (I1**2 - ufl.tr(C * C))
        shape = c10 * (J2 ** (-1.0 / 3.0) * I1 - 3.0) + c01 * (J2 ** (-2.0 / 3.0) * I2 - 3.0)
        return shape + 0.25 * kappa * (J2 - 1.0 - ufl.ln(J2))
