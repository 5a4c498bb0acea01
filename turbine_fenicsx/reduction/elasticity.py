"""Stiffness and viscosity of a body at a point of each cell, from its law as a UFL expression.

Strains are (E11, E22, E33, 2 E23, 2 E13, 2 E12), stresses (S11, S22, S33, S23, S13, S12).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from dolfinx import fem

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.base import Viscous, stress_at_rest
from turbine_fenicsx.materials.cell_fields import parameters_on
from turbine_fenicsx.materials.pointwise import CellPoints, UnknownExpression, write_out

ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Entries of a symmetric tensor in the order of its six numbers."""

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
    """The law of a body, written out to be evaluated at points. Collective.

    Args:
        body: The body.

    Raises:
        ModelError: for a law that is not quadratic in the strain.
    """

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
        self._strain = fem.Constant(mesh, np.zeros((3, 3)))
        parameter = parameters_on(mesh, kind)

        def energy(C: Any) -> Any:
            return material.strain_energy(C, parameter)

        self._stress = _write(stress_at_rest(energy, self._strain, True))
        self._viscous = None
        if isinstance(material, Viscous):
            self._viscous = _write(material.viscous_stress(self._strain, parameter))

    @property
    def is_viscous(self) -> bool:
        """Whether it has a viscous stress."""
        return self._viscous is not None

    def tabulate(self, cells: IntArray, point: Array) -> Elasticity:
        """Matrices at the same point of some cells of this rank.

        Args:
            cells: Local cells, shape (n,).
            point: The point of the reference cell, shape (3,).

        Raises:
            ModelError: for a stress at rest, and a viscosity that is not linear or symmetric.
        """
        at = CellPoints(self._mesh, cells, point)
        try:
            stiffness, rest = self._differentiate(at, self._stress, 1.0)
            viscosity = None
            if self._viscous is not None:
                viscosity, _ = self._differentiate(at, self._viscous, 1.0)
                twice, _ = self._differentiate(at, self._viscous, 2.0)
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

    def _differentiate(self, at: CellPoints, stress: list[Any], size: float) -> tuple[Array, Array]:
        """Stresses of six strains of a size, shape (cells, 6, 6), and without strain."""
        strains = np.zeros((7, 3, 3))
        for k, (i, j) in enumerate(ENTRIES):
            strains[k, i, j] = strains[k, j, i] = size if i == j else 0.5 * size
        S = at.evaluate(stress, {self._strain: strains}).swapaxes(1, 2)
        return S[:, :, :6], S[:, :, 6]


def _write(stress: Any) -> list[Any]:
    """The six entries of a stress."""
    return [write_out(stress[i, j]) for i, j in ENTRIES]
