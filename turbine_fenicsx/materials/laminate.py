"""Walls of laminates as a solid, one cell through the thickness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.core.expr import Expr

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.base import Quadrature
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.kinematics import green_lagrange
from turbine_fenicsx.materials.laminate_theory import WallTable
from turbine_fenicsx.materials.wall_axes import thickness_coordinate, wall_frame
from turbine_fenicsx.materials.wall_quadrature import wall_quadrature


@dataclass(frozen=True, eq=False)
class Laminate:
    """W = e:Q e/2 + E3 e33^2/2 + g:G g/2 in the axes of the wall.

    e = (E11, E22, 2 E12) are the strains in the wall, Q their plane-stress stiffness; E33 is the
    strain through it and g = (2 E13, 2 E23) the shear. The wall gets no thinner when it is
    stretched. Axes and coordinate come from the shape of the cells, see
    `turbine_fenicsx.materials.wall_axes`.

    Args:
        in_plane: Q, a cell field of the six entries 11, 12, 13, 22, 23, 33 of a matrix [Pa]; or of
            the eighteen of Q0, Q1 and Q2 in Q = Q0 + Q1 zeta + Q2 zeta^2.
        through: A cell field of E3, G11, G12, G22 [Pa].
        quadrature: Points at which the energy is sampled, those of
            `turbine_fenicsx.materials.wall_quadrature`.

    Raises:
        ModelError: for fields with another number of components, or on a mesh of other cells than
            hexahedra, and quadrilaterals of a section.
    """

    in_plane: fem.Function
    through: fem.Function
    quadrature: Quadrature = field(default_factory=wall_quadrature)
    quadratic = True

    def __post_init__(self) -> None:
        shapes = self.in_plane.ufl_shape, self.through.ufl_shape
        if shapes not in (((6,), (4,)), ((18,), (4,))):
            raise ModelError(
                "a laminate needs cell fields of 6 or 18 components in the plane and of 4 through "
                f"the wall, got shapes {shapes[0]} and {shapes[1]}"
            )
        cell = _compat.cell_name(self.mesh)
        if cell not in ("hexahedron", "quadrilateral"):
            raise ModelError(
                f"a laminate needs a mesh of hexahedra, or a section of quadrilaterals, got {cell} "
                "cells"
            )

    @classmethod
    def from_table(cls, mesh: Mesh, table: WallTable) -> Laminate:
        """The law of the cells that this rank owns. Collective.

        Args:
            mesh: The mesh.
            table: A row for each of these cells, as `tabulate_walls` makes it.
        """
        return cls(cell_field(mesh, table.in_plane), cell_field(mesh, table.through))

    @property
    def mesh(self) -> Mesh:
        """The mesh of its fields."""
        return self.in_plane.function_space.mesh

    @cached_property
    def _zeta(self) -> fem.Function:
        """The coordinate through the wall."""
        return thickness_coordinate(self.mesh)

    @property
    def frame(self) -> tuple[Expr, Expr, Expr]:
        """Axes along the span, around the section and outwards, as UFL vectors."""
        return wall_frame(self.mesh)

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy [J/m^3]."""
        q, (E3, G11, G12, G22) = parameter(self.in_plane), parameter(self.through)
        if len(q) > 6:
            zeta = parameter(self._zeta)
            q = [q[k] + zeta * (q[6 + k] + zeta * q[12 + k]) for k in range(6)]
        Q = ufl.as_matrix([[q[0], q[1], q[2]], [q[1], q[3], q[4]], [q[2], q[4], q[5]]])
        E = green_lagrange(C)
        a1, a2, a3 = self.frame
        e = ufl.as_vector([ufl.dot(a1, E * a1), ufl.dot(a2, E * a2), 2.0 * ufl.dot(a1, E * a2)])
        g1, g2, e33 = 2.0 * ufl.dot(a1, E * a3), 2.0 * ufl.dot(a2, E * a3), ufl.dot(a3, E * a3)
        shear = G11 * g1**2 + 2.0 * G12 * g1 * g2 + G22 * g2**2
        return 0.5 * (ufl.dot(e, Q * e) + E3 * e33**2 + shear)
