"""Transversely isotropic material for large strains, which resists being crushed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.cell_fields import Scalar, is_field, map_cells
from turbine_fenicsx.materials.orthotropic import stiffness_matrix


@dataclass(frozen=True, eq=False)
class TransverselyIsotropic:
    """A stiffness that is isotropic about a fibre, continued to large strains.

    With the unit vector a along the fibre, what the law measures is, each zero at rest,

        y = ln |F a|,                            stretch of the fibre: exp(2 y) = I4 = a.C a
        z = ln J - y,                            area normal to the fibre: A = exp(z)
        h = (tr C - I5/I4)/2 - A >= 0,           shear in that area, I5 = |C a|^2
        t = I5/I4 - I4 >= 0,                     shear along the fibre

    and the energy is

        W = s mu [(I4 - 1)/2 - y + A - 1 - z] + mu h + G/2 t + (K11 y^2 + 2 K12 y z + K22 z^2)/2
        K11 = D11 - 2 s mu,    K12 = D12,    K22 = (D22 + D23)/2 - s mu,    mu = (D22 - D23)/2

    D is the stiffness at rest, the general one of this symmetry, and G the axial shear modulus. The
    share 0 < s <= 1 of the neo-Hookean terms is the largest that leaves K positive semidefinite. It
    is 1 for usual composites, and less if the fibre is softer than the matrix or the transverse
    Poisson's ratio is small. So W is positive except for rotations and grows without bound whenever
    any stretch goes to zero or to infinity, for every D that is positive definite. With isotropic
    constants, Poisson's ratio not negative, it is `NeoHooke`.

    `OrthotropicSVK` with the same constants has the same stiffness at rest and is cheaper, but
    its resistance to compression along an axis vanishes as the length does.

    Args:
        young_axial: E1 along the fibre [Pa], positive.
        young_transverse: E2 = E3 [Pa], positive.
        shear_axial: G = G12 = G13 [Pa], positive.
        poisson_axial: nu12 = nu13 [-], contraction normal to the fibre under tension along it.
        poisson_transverse: nu23 [-]; it gives G23 = mu = E2/(2 (1 + nu23)), eq. (64).
        fibre: Direction of the fibre in the reference configuration as a UFL vector, a constant
            or a field on the mesh; any length but zero.

    Raises:
        ModelError: if the stiffness is not positive definite.
    """

    young_axial: Scalar
    young_transverse: Scalar
    shear_axial: Scalar
    poisson_axial: Scalar
    poisson_transverse: Scalar
    fibre: Expr
    quadratic = False

    def __post_init__(self) -> None:
        _ = self._constants

    def stiffness(self) -> Array:
        """Stiffness D at rest with the fibre along axis 1, Voigt order 11, 22, 33, 23, 13, 12.

        Returns:
            Shape (6, 6) [Pa], symmetric positive definite; for constants that are numbers.
        """
        return _stiffness(*self._given)

    @property
    def _given(self) -> tuple[Any, ...]:
        """E1, E2, G, nu12, nu23."""
        axial, transverse = self.young_axial, self.young_transverse
        return axial, transverse, self.shear_axial, self.poisson_axial, self.poisson_transverse

    @cached_property
    def _constants(self) -> list[Any]:
        """mu, s mu, G, K11, K12, K22: numbers, or cell fields."""

        def constants(*given: float) -> Array:
            D = _stiffness(*given)
            mu, share = D[3, 3], neo_hookean_share(D) * D[3, 3]
            K22 = 0.5 * (D[1, 1] + D[1, 2]) - share
            return np.array([mu, share, D[5, 5], D[0, 0] - 2.0 * share, D[0, 1], K22])

        if any(is_field(value) for value in self._given):
            return map_cells(constants, *self._given)
        return [float(value) for value in constants(*self._given)]

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        mu, share, G, K11, K12, K22 = (parameter(value) for value in self._constants)
        a = self.fibre / ufl.sqrt(ufl.dot(self.fibre, self.fibre))
        I4, I5 = ufl.dot(a, C * a), ufl.dot(C * a, C * a)
        A2 = ufl.det(C) / I4
        A, y, z = ufl.sqrt(A2), 0.5 * ufl.ln(I4), 0.5 * ufl.ln(A2)
        h, t = 0.5 * (ufl.tr(C) - I5 / I4) - A, I5 / I4 - I4
        W = share * (0.5 * (I4 - 1.0) - y + A - 1.0 - z) + mu * h + 0.5 * G * t
        return W + 0.5 * (K11 * y**2 + 2.0 * K12 * y * z + K22 * z**2)


def _stiffness(E1: float, E2: float, G: float, n12: float, n23: float) -> Array:
    """Stiffness D of `TransverselyIsotropic`, shape (6, 6) [Pa]."""
    D = stiffness_matrix((E1, E2, E2), (G, G, G), (n12, n12, n23))
    D[3, 3] = 0.5 * (D[1, 1] - D[1, 2])
    return D


def neo_hookean_share(D: Array) -> float:
    """Largest s <= 1 for which K of `TransverselyIsotropic` is positive semidefinite.

    With k = (D22 + D23)/2 the smaller root of

        det K = 2 mu^2 s^2 - (D11 + 2 k) mu s + (D11 k - D12^2)

    or one: det K is positive for s = 0, as D is positive definite.

    Args:
        D: Stiffness in Voigt order, shape (6, 6) [Pa].

    Returns:
        s, positive.
    """
    mu, k = 0.5 * (D[1, 1] - D[1, 2]), 0.5 * (D[1, 1] + D[1, 2])
    D11, D12 = D[0, 0], D[0, 1]
    twice = D11 + 2.0 * k + np.hypot(D11 - 2.0 * k, np.sqrt(8.0) * D12)
    # the root without cancellation, as the product of both is (D11 k - D12^2)/(2 mu^2)
    return float(min(1.0, 2.0 * (D11 * k - D12**2) / (mu * twice)))
