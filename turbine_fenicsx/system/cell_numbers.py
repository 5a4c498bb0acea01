"""Numbers of each cell of a mesh: integrals over it, or values at its centre.

They are linear forms whose test functions are constant in each cell, so that they are computed for
several cells at once as forces are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from petsc4py import PETSc

import numpy as np
import ufl

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.linear_form import LinearForm

REFERENCE_VOLUME = {"hexahedron": 1.0, "tetrahedron": 1.0 / 6.0}


class CellNumbers:
    """Integrals over each cell of expressions whose coefficients may change.

    Args:
        mesh: The mesh.
        integrands: Lists of scalar expressions, each with its measure over all cells.

    Note:
        Collective.
    """

    def __init__(self, mesh: Any, *integrands: tuple[Sequence[Any], Any]) -> None:
        self._n = sum(len(expressions) for expressions, _ in integrands)
        space = _compat.cellwise_space(mesh, (self._n,))
        w, first, form = ufl.TestFunction(space), 0, 0
        for expressions, dx in integrands:
            form += sum(e * w[first + k] for k, e in enumerate(expressions)) * dx
            first += len(expressions)
        self._form = LinearForm(form)
        cells = space.dofmap.index_map
        self._cells = cells.size_local
        self._vector = PETSc.Vec().createGhost(
            cells.ghosts.astype(PETSc.IntType),
            size=(self._n * self._cells, self._n * cells.size_global),
            bsize=self._n,
            comm=mesh.comm,
        )

    def sums(self) -> Array:
        """Sums over the cells that this rank owns, shape (numbers,). Collective."""
        self._form.assemble(self._vector)
        found: Array = np.ones(self._cells) @ self._vector.array_r.reshape(-1, self._n)
        return found

    def of_cells(self) -> Array:
        """The numbers of the local cells, ghosts included, shape (cells, numbers). Collective."""
        self._form.assemble(self._vector)
        self._vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        with self._vector.localForm() as local:
            return np.array(local.array_r).reshape(-1, self._n)


def at_centres(mesh: Any, *expressions: Any) -> CellNumbers:
    """Values of scalar expressions at the centre of each cell. Collective.

    Args:
        mesh: The mesh.
        expressions: The expressions.
    """
    centre = ufl.dx(domain=mesh, metadata={"quadrature_degree": 1})  # one point
    volume = REFERENCE_VOLUME[_compat.cell_name(mesh)] * abs(ufl.JacobianDeterminant(mesh))
    return CellNumbers(mesh, ([e / volume for e in expressions], centre))
