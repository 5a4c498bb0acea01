"""Kelvin-Voigt material: a viscous stress beside the elastic one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.materials.base import Material, Quadrature, Sampled, Viscous
from turbine_fenicsx.materials.cell_fields import Scalar, check_cells


@dataclass(frozen=True, eq=False)
class KelvinVoigt:
    """S = 2 dW/dC + 2 eta_s dev(E') + eta_b tr(E') I, any material with damping.

    E' is the rate of the Green-Lagrange strain E = (C - I)/2, so that rigid motion is not damped
    and angular momentum is conserved. In a step E' = (E_{n+1} - E_n)/dt; the energy that a step
    takes out of the body is then

        int S_v : (E_{n+1} - E_n) dV >= 0

    exactly, whatever the size of the step. Damping grows with frequency. With eta_s = tau mu and
    eta_b = tau (Lambda + 2 mu/3), each mode of an isotropic body is damped by the ratio tau w/2: w
    is its angular frequency [rad/s], tau a time [s].

    Args:
        elastic: Material of the elastic stress, not viscous itself.
        shear_viscosity: eta_s [Pa s], not negative, a number or a `cell_field`.
        bulk_viscosity: eta_b [Pa s], not negative, a number or a `cell_field`.

    Raises:
        ModelError: for a viscosity that is negative or no number.
        TypeError: if ``elastic`` is no material, or viscous already.
    """

    elastic: Material
    shear_viscosity: Scalar
    bulk_viscosity: Scalar = 0.0

    def __post_init__(self) -> None:
        for name in ("shear", "bulk"):
            check_cells(
                f"{name} viscosity must not be negative, got {{{name}_viscosity}} Pa s",
                lambda eta: (eta >= 0.0) & (eta < np.inf),
                **{f"{name}_viscosity": getattr(self, f"{name}_viscosity")},
            )
        if not isinstance(self.elastic, Material):
            raise TypeError(
                "the elastic part of a viscous material must be a material, got "
                f"{describe(self.elastic)}"
            )
        if isinstance(self.elastic, Viscous):
            raise TypeError(
                "the elastic part of a viscous material must not be viscous itself, got "
                f"{describe(self.elastic)}"
            )

    @property
    def quadratic(self) -> bool:
        """Whether W is quadratic in C."""
        return self.elastic.quadratic

    @property
    def quadrature(self) -> Quadrature | None:
        """Points of the elastic material."""
        return self.elastic.quadrature if isinstance(self.elastic, Sampled) else None

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy of the elastic material [J/m^3]."""
        return self.elastic.strain_energy(C, parameter)

    def viscous_stress(self, E_dot: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Viscous second Piola-Kirchhoff stress S_v [Pa] as a UFL expression, shape (3, 3)."""
        eta_s, eta_b = parameter(self.shear_viscosity), parameter(self.bulk_viscosity)
        return 2.0 * eta_s * ufl.dev(E_dot) + eta_b * ufl.tr(E_dot) * ufl.Identity(3)
