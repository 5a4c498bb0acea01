"""Stresses and fibres of a flexible body at the centres of its cells, eqs (69)-(70)."""

from __future__ import annotations

from functools import cached_property

from petsc4py import PETSc

import ufl
from dolfinx import fem

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import cauchy_stress
from turbine_fenicsx.materials.kinematics import deformation_gradient
from turbine_fenicsx.system.cell_numbers import CentreValues
from turbine_fenicsx.system.flexible_model import FlexibleModel


class CellCentres:
    """Values at the centres of the local cells, ghosts included; forms compile on first use.

    Args:
        model: The body.

    Note:
        Collective, also its methods.
    """

    def __init__(self, model: FlexibleModel) -> None:
        self._model, self._u = model, fem.Function(model.space)
        self._F = deformation_gradient(self._u)

    def stresses(self, u: PETSc.Vec) -> tuple[Array, Array]:
        """Norm of the Cauchy stress, and von Mises stress [Pa], without viscosity.

        Args:
            u: Displacement.

        Returns:
            Shapes (cells,).
        """
        self._model.copy_to(self._u, u)
        norm, von_mises = self._stresses.in_cells().T.copy()
        return norm, von_mises

    def fibres(self, u: PETSc.Vec | None = None) -> Array | None:
        """Unit vectors along the deformed fibres, shape (cells, 3); None without fibres.

        Args:
            u: Displacement; zero if None.
        """
        if self._model.body.fibre is None:
            return None
        if u is None:
            self._u.x.array[:] = 0.0
        else:
            self._model.copy_to(self._u, u)
        return self._fibres.in_cells()

    @cached_property
    def _stresses(self) -> CentreValues:
        """Norm and von Mises stress."""
        sigma = cauchy_stress(self._model.energy, self._F)
        return CentreValues(
            self._model.body.mesh,
            *(ufl.sqrt(a * ufl.inner(s, s)) for a, s in ((1.0, sigma), (1.5, ufl.dev(sigma)))),
        )

    @cached_property
    def _fibres(self) -> CentreValues:
        """Components of the unit vectors."""
        a = self._F * self._model.body.fibre
        units = (a[i] / ufl.sqrt(ufl.dot(a, a)) for i in range(3))
        return CentreValues(self._model.body.mesh, *units)
