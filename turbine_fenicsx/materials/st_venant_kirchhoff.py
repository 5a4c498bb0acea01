"""Isotropic St. Venant-Kirchhoff material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.materials.cell_fields import Scalar
from turbine_fenicsx.materials.kinematics import green_lagrange
from turbine_fenicsx.materials.lame import check_lame


@dataclass(frozen=True)
class StVenantKirchhoff:
    """W = Lambda/2 (tr E)^2 + mu E:E, eq. (67) for the paper's soft blades.

    Args:
        first_lame: Lambda [Pa], a number or a `cell_field`.
        shear_modulus: mu [Pa], positive, a number or a `cell_field`; the bulk modulus
            Lambda + 2 mu/3 must be positive too.

    Raises:
        ModelError: if the energy is not positive definite.
    """

    first_lame: Scalar
    shear_modulus: Scalar
    quadratic = True

    def __post_init__(self) -> None:
        check_lame(self.first_lame, self.shear_modulus)

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        lam, mu = parameter(self.first_lame), parameter(self.shear_modulus)
        E = green_lagrange(C)
        return 0.5 * lam * ufl.tr(E) ** 2 + mu * ufl.inner(E, E)
