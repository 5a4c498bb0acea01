"""Stiffness and viscosity of a body at a point of each cell, from its law as a UFL expression.

Strains are (E11, E22, E33, 2 E23, 2 E13, 2 E12), stresses (S11, S22, S33, S23, S13, S12).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from dolfinx import fem

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.base import Viscous
from turbine_fenicsx.materials.cell_fields import parameters_on
from turbine_fenicsx.materials.pointwise import CellPoints, UnknownExpression, write_out

ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Entries of a symmetric tensor in the order of its six numbers."""

STRAINS: Array = np.array(
    [0.5 * (np.outer(a, b) + np.outer(b, a)) for a, b in (np.eye(3)[[i, j]] for i, j in ENTRIES)]
)
"""A strain for each of the six numbers that is one."""

ROUND_OFF = 1e-10
"""Asymmetry, and change with the size of the rate, of a viscosity that is linear."""


class Elasticity(NamedTuple):
    """Matrices of some cells, and where they are.

    Attributes:
        stiffness: Stresses per strain, shape (cells, 6, 6) [Pa].
        viscosity: Stresses per strain rate, of the same shape [Pa s]; None without viscosity.
        jacobians: Derivatives of the place with respect to that in the reference cell, shape
            (cells, 3, 3).
    """

    stiffness: Array
    viscosity: Array | None
    jacobians: Array


class Law:
    """The law of a body, written out to be evaluated at points. Collective."""

    def __init__(self, body: FlexibleBody) -> None:
        material, mesh = body.material, body.mesh
        kind = f"law {type(material).__name__} of {body.name!r}"
        if not material.quadratic:
            raise ModelError(
                f"{kind} is not quadratic in the strain: the energy of a reduced body is a "
                "quadratic function only of such laws, St. Venant-Kirchhoff, transversely "
                "isotropic, orthotropic or Laminate for example"
            )
        self._mesh, self._kind = mesh, kind
        self._tensor = fem.Constant(mesh, np.zeros((3, 3)))
        parameter = parameters_on(mesh, kind)
        self._energy = write_out(material.strain_energy(self._tensor, parameter))
        self._viscous = None
        if isinstance(material, Viscous):
            S = material.viscous_stress(self._tensor, parameter)
            self._viscous = [write_out(S[i, j]) for i, j in ENTRIES]

    @property
    def is_viscous(self) -> bool:
        """Whether it has a viscous stress."""
        return self._viscous is not None

    def tabulate(self, cells: IntArray, point: Array) -> Elasticity:
        """Matrices at the same point of some cells of this rank.

        Args:
            cells: Local cells, shape (n,).
            point: The point of the reference cell, shape (3,).
        """
        at = CellPoints(self._mesh, cells, point)
        try:
            stiffness, rest = self._differentiate_energy(at)
            viscosity = None
            if self._viscous is not None:
                viscosity, twice = (
                    at.evaluate(self._viscous, {self._tensor: size * STRAINS}).swapaxes(1, 2)
                    for size in (1.0, 2.0)
                )
        except UnknownExpression as unknown:
            raise ModelError(
                f"{self._kind} depends on {unknown}, of which no value is known outside of a form: "
                "the body cannot be reduced"
            ) from None
        size = np.max(np.abs(stiffness), initial=0.0)
        if np.max(np.abs(rest), initial=0.0) > ROUND_OFF * size:
            raise ModelError(f"{self._kind} has a stress at rest: the body cannot be reduced")
        if viscosity is not None:
            wrong = [viscosity - viscosity.swapaxes(1, 2), twice - 2.0 * viscosity]
            largest = max(float(np.max(np.abs(x), initial=0.0)) for x in wrong)
            if largest > ROUND_OFF * np.max(np.abs(viscosity), initial=0.0):
                raise ModelError(
                    f"{self._kind} has a viscous stress that is not linear in the rate or not "
                    "symmetric: the body cannot be reduced"
                )
        return Elasticity(stiffness, viscosity, at.jacobians)

    def _differentiate_energy(self, at: CellPoints) -> tuple[Array, Array]:
        """Stiffness, shape (cells, 6, 6), and stress at rest, shape (cells, 6).

        For W = W_0 + S_0.e + e.D e/2 differences are exact, of unit strains e_i and their sums:
        D_ij = W(e_i + e_j) - W(e_i) - W(e_j) + W_0.
        """
        i, j = np.triu_indices(6)
        strains = np.concatenate([np.zeros((1, 3, 3)), STRAINS, STRAINS[i] + STRAINS[j]])
        W = at.evaluate([self._energy], {self._tensor: np.eye(3) + 2.0 * strains})[..., 0]
        single = W[:, 1:7] - W[:, :1]
        D = np.zeros((len(W), 6, 6))
        D[:, i, j] = D[:, j, i] = W[:, 7:] - W[:, :1] - single[:, i] - single[:, j]
        return D, single - 0.5 * np.einsum("cii->ci", D)
