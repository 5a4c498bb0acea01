"""Compressible neo-Hookean material, whose energy is not quadratic in C."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.materials.cell_fields import Scalar
from turbine_fenicsx.materials.lame import check_lame


@dataclass(frozen=True)
class NeoHooke:
    """W = mu/2 (tr C - 3) - mu ln J + Lambda/2 (ln J)^2 with J = sqrt(det C).

    Args:
        first_lame: Lambda [Pa], a number or a `cell_field`.
        shear_modulus: mu [Pa], positive, a number or a `cell_field`.

    Raises:
        ModelError: if the energy is not positive definite at the reference state.
    """

    first_lame: Scalar
    shear_modulus: Scalar
    quadratic = False

    def __post_init__(self) -> None:
        check_lame(self.first_lame, self.shear_modulus)

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        lam, mu = parameter(self.first_lame), parameter(self.shear_modulus)
        ln_J = 0.5 * ufl.ln(ufl.det(C))
        return 0.5 * mu * (ufl.tr(C) - 3.0) - mu * ln_J + 0.5 * lam * ln_J**2
