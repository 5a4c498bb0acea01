"""Isotropic St. Venant-Kirchhoff material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl

from turbine_fenicsx.materials.cell_fields import check_cells
from turbine_fenicsx.materials.kinematics import green_lagrange


@dataclass(frozen=True)
class StVenantKirchhoff:
    """W = Lambda/2 (tr E)^2 + mu E:E, eq. (67) for the paper's soft blades.

    Args:
        first_lame: Lambda [Pa], a number or a `cell_field`.
        shear_modulus: mu [Pa], positive, a number or a `cell_field`; the bulk modulus
            Lambda + 2 mu/3 must be positive too.

    Raises:
        ValueError: if the energy is not positive definite.
    """

    first_lame: float
    shear_modulus: float
    quadratic = True

    def __post_init__(self) -> None:
        """Check positive definiteness."""
        check_lame(self.first_lame, self.shear_modulus)

    def strain_energy(self, C: Any, parameter: Callable[[Any], Any]) -> Any:
        """Strain energy [J/m^3]."""
        lam, mu = parameter(self.first_lame), parameter(self.shear_modulus)
        E = green_lagrange(C)
        return 0.5 * lam * ufl.tr(E) ** 2 + mu * ufl.inner(E, E)


def check_lame(first_lame: Any, shear_modulus: Any) -> None:
    """Raise a ValueError unless shear and bulk modulus are positive, in all cells."""
    words = "material is not positive definite: "
    check_cells(
        words + "shear modulus {shear_modulus} Pa",
        lambda mu: (mu > 0.0) & (mu < np.inf),
        shear_modulus=shear_modulus,
    )
    check_cells(
        words + "bulk modulus Lambda + 2 mu/3, Lambda {first_lame} Pa, mu {shear_modulus} Pa",
        lambda lam, mu: (lam + 2.0 * mu / 3.0 > 0.0) & (lam < np.inf),
        first_lame=first_lame,
        shear_modulus=shear_modulus,
    )
