"""Strains, stresses and failure indices of the plies in the walls of a section.

With the tangent a_2 of a face of the wall, the arc length s along it, and the derivative u' along
the prism (see `turbine_fenicsx.sections.saint_venant`), the strains in the wall are

    E_11 = u'_z,    E_22 = a_2 . du/ds,    2 E_12 = du_z/ds + a_2 . u'.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.laminate_theory import Plies
from turbine_fenicsx.materials.ply_table import Criterion, PlyTable
from turbine_fenicsx.materials.wall_quadrature import gauss_quadrature
from turbine_fenicsx.sections.section import Section, check_loads

POINTS = 2
"""Points of a face, around the section."""


class SectionPlies:
    """Where the plies of a section are strained, and how near they are to failing.

    Strains are those at both faces of the wall, at two points of each, and straight between the
    faces. Stresses are those of plane stress in the plies.

    Args:
        section: A section whose walls are one quadrilateral thick, with cells as
            `turbine_fenicsx.materials.laminate.Laminate` needs them.
        laminates: The plies of each cell of its mesh, from the outer to the inner face.

    Attributes:
        table: The plies of these cells.

    Raises:
        ModelError: for a mesh of other cells, another number of laminates than cells, and a cell
            without plies.
    """

    def __init__(self, section: Section, laminates: Sequence[Plies]) -> None:
        self._section, cell = section, _compat.cell_name(section.mesh)
        if cell != "quadrilateral":
            raise ModelError(f"plies of a section need a mesh of quadrilaterals, got {cell} cells")
        n = len(_compat.nodes_of_cells(section.mesh))
        if len(laminates) != n or not all(laminates):
            raise ModelError(
                f"plies of a section are needed for each of its {n} cells, got {len(laminates)} "
                f"laminates, {sum(not plies for plies in laminates)} of them without plies"
            )
        self.table = PlyTable(laminates)

    @cached_property
    def _unit_strains(self) -> Array:
        """Strains 11, 22, 12 of unit loads, shape (cells, 2 faces from inside, POINTS, 3, 6)."""
        section = self._section
        space, geometry = section.prism.space, section.mesh.geometry.x
        nodes, cells = _compat.nodes_of_cells(section.mesh), _compat.dofs_of_cells(space)
        points = np.repeat(gauss_quadrature(1, POINTS, 1).points[None, :, 1:], 2, axis=0)
        points[0, :, 1], points[1, :, 1] = 0.0, 1.0
        _, by_xi = _evaluate(nodes.shape[1], points)
        tangent = np.einsum("fqa,cai->cfqi", by_xi, geometry[nodes])
        length = np.linalg.norm(tangent, axis=-1)
        a2 = tangent / length[..., None]
        N, by_xi = _evaluate(cells.shape[1], points)
        u, v = (
            x.reshape(-1, 3, 6)[cells]
            for x in (section.unit_loads.warping, section.unit_loads.derivative)
        )
        by_s = np.einsum("fqa,caik->cfqik", by_xi, u) / length[..., None, None]
        along = np.einsum("fqa,caik->cfqik", N, v)
        e22, shear = (np.einsum("cfqi,cfqik->cfqk", a2, x) for x in (by_s, along))
        return np.stack([along[..., 2, :], e22, by_s[..., 2, :] + shear], axis=-2)

    def strains(self, loads: npt.ArrayLike) -> Array:
        """Along the fibre, across it, and shear, at both faces of each ply and at two points.

        Args:
            loads: Forces along x, y, z and moments about them, shape (6,) [N, N m].

        Returns:
            Shape (plies, 2, 2, 3), outer faces first.
        """
        inner, outer = np.moveaxis(self._unit_strains @ check_loads(loads), 1, 0)
        return self.table.strains(inner, outer)

    def stresses(self, loads: npt.ArrayLike) -> Array:
        """Those of `strains` [Pa]."""
        return self.table.stresses(self.strains(loads))

    def largest(self, loads: npt.ArrayLike, criterion: Criterion) -> tuple[Array, IntArray]:
        """The largest failure index of each cell, and the ply where it is.

        Args:
            loads: As in `strains`.
            criterion: One of `turbine_fenicsx.materials.ply_failure`.

        Returns:
            Shapes (cells,); plies count from the outer face, from 0.
        """
        return self.table.largest(criterion(self.table, self.strains(loads)))


def _evaluate(nodes: int, points: Array) -> tuple[Array, Array]:
    """Shape functions of a cell and their derivatives around the section, (2, POINTS, nodes)."""
    degree = round(nodes**0.5) - 1
    N, dN = _compat.shape_functions("quadrilateral", degree, points.reshape(-1, 2))
    return N.reshape(2, POINTS, nodes), dN[..., 0].reshape(2, POINTS, nodes)
