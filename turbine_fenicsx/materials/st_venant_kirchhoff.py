"""Isotropic St. Venant-Kirchhoff material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ufl

from turbine_fenicsx.kinematics import green_lagrange


@dataclass(frozen=True)
class StVenantKirchhoff:
    """W = Lambda/2 (tr E)^2 + mu E:E, eq. (67) for the paper's soft blades.

    Args:
        first_lame: Lambda [Pa].
        shear_modulus: mu [Pa], positive; the bulk modulus Lambda + 2 mu/3 must be positive too.

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


def check_lame(first_lame: float, shear_modulus: float) -> None:
    """Raise a ValueError unless shear and bulk modulus are positive."""
    if not shear_modulus > 0.0:
        raise ValueError(f"material is not positive definite: shear modulus {shear_modulus:g} Pa")
    bulk = first_lame + 2.0 * shear_modulus / 3.0
    if not bulk > 0.0:
        raise ValueError(f"material is not positive definite: bulk modulus {bulk:g} Pa")
