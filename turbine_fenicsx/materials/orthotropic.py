"""Orthotropic and transversely isotropic St. Venant-Kirchhoff material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any

import numpy as np
import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.cell_fields import Scalar, is_field, map_cells
from turbine_fenicsx.materials.kinematics import green_lagrange

Triple = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class OrthotropicSVK:
    """W = E:D:E/2 with the stiffness D given by engineering constants in a material frame.

    The paper's transversely isotropic blades, eqs (62)-(66), have the fibre along axis 1. Their
    listed G23 contradicts eq. (64), which says E2/(2 (1 + nu23)); the listed value is taken as it
    stands, so that this material is orthotropic in general.

    Args:
        young: E1, E2, E3 [Pa].
        shear: G12, G13, G23 [Pa].
        poisson: nu12, nu13, nu23 [-]; nu_ij is the contraction along j under tension along i.
            Each of the nine is a number or a `cell_field`.
        frame: Orthonormal axes (a1, a2, a3) as UFL vectors: constants or fields on the mesh.

    Raises:
        ModelError: if the stiffness is not positive definite.
    """

    _: KW_ONLY
    young: tuple[Scalar, Scalar, Scalar]
    shear: tuple[Scalar, Scalar, Scalar]
    poisson: tuple[Scalar, Scalar, Scalar]
    frame: tuple[Expr, Expr, Expr]
    quadratic = True

    def __post_init__(self) -> None:
        _ = self._entries

    @cached_property
    def _entries(self) -> list[Any]:
        """D of the normal strains row by row, G12, G13, G23: numbers, or cell fields."""

        def entries(*given: Any) -> Array:
            D = stiffness_matrix(given[:3], given[3:6], given[6:])
            return np.append(D[:3, :3].ravel(), D[[5, 4, 3], [5, 4, 3]])

        given = (*self.young, *self.shear, *self.poisson)
        if any(is_field(value) for value in given):
            return map_cells(entries, *given)
        return [float(value) for value in entries(*given)]

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        D, G12, G13, G23 = self._entries[:9], *(parameter(G) for G in self._entries[9:])
        rows = [D[:3], D[3:6], D[6:]]
        # numbers are one constant of the form, fields one function each
        normal = ufl.as_matrix(rows) if is_field(D[0]) else parameter(rows)
        E = green_lagrange(C)
        a1, a2, a3 = self.frame
        e = ufl.as_vector([ufl.dot(a, E * a) for a in self.frame])
        E12, E13, E23 = (ufl.dot(a, E * b) for a, b in ((a1, a2), (a1, a3), (a2, a3)))
        return 0.5 * ufl.dot(e, normal * e) + 2.0 * (G12 * E12**2 + G13 * E13**2 + G23 * E23**2)


def stiffness_matrix(young: Triple, shear: Triple, poisson: Triple) -> Array:
    """Stiffness D in Voigt order 11, 22, 33, 23, 13, 12 for engineering shear strains, eq. (63).

    Args:
        young: E1, E2, E3 [Pa].
        shear: G12, G13, G23 [Pa].
        poisson: nu12, nu13, nu23 [-].

    Returns:
        Shape (6, 6) [Pa], symmetric positive definite.
    """
    if not all(0.0 < modulus < np.inf for modulus in (*young, *shear)):
        raise ModelError(
            f"material is not positive definite: Young's moduli {young} and shear moduli {shear} "
            "must be positive"
        )
    (E1, E2, E3), (G12, G13, G23), (n12, n13, n23) = young, shear, poisson
    compliance = np.array(
        [
            [1.0 / E1, -n12 / E1, -n13 / E1],
            [-n12 / E1, 1.0 / E2, -n23 / E2],
            [-n13 / E1, -n23 / E2, 1.0 / E3],
        ]
    )
    if not np.all(np.isfinite(poisson)) or np.linalg.eigvalsh(compliance * max(young))[0] <= 1e-12:
        raise ModelError(
            f"material is not positive definite: Poisson's ratios {poisson} are too large for "
            f"Young's moduli {young}"
        )
    D = np.diag([0.0, 0.0, 0.0, G23, G13, G12])
    D[:3, :3] = np.linalg.inv(compliance)
    return D
