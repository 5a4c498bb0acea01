"""Numbers of each cell of a mesh: integrals over it, or values at its centre.

They are linear forms whose test functions live in one cell each, so that they are computed for
several cells together as forces are.
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

CENTRE = {"hexahedron": [[0.5, 0.5, 0.5]], "tetrahedron": [[0.25, 0.25, 0.25]]}


class CellNumbers:
    """Integrals over each cell of expressions whose coefficients may change. Collective.

    Args:
        integrands: Lists of scalar expressions, each with its measure over all cells.
    """

    def __init__(self, mesh: Any, *integrands: tuple[Sequence[Any], Any]) -> None:
        n = sum(len(expressions) for expressions, _ in integrands)
        space = _compat.cellwise_space(mesh, (n,))
        w, first, form = ufl.TestFunction(space), 0, 0
        for expressions, dx in integrands:
            form += sum(e * w[first + k] for k, e in enumerate(expressions)) * dx
            first += len(expressions)
        self._form = LinearForm(form)
        dofs = space.dofmap.index_map
        self._dofs, self._n = _compat.dofs_of_cells(space), n
        self._vector = PETSc.Vec().createGhost(
            dofs.ghosts.astype(PETSc.IntType),
            size=(n * dofs.size_local, n * dofs.size_global),
            bsize=n,
            comm=mesh.comm,
        )

    def sums(self) -> Array:
        """Sums over the cells that this rank owns, shape (expressions,). Collective."""
        self._form.assemble(self._vector)
        rows = self._vector.array_r.reshape(-1, self._n)
        found: Array = np.ones(len(rows)) @ rows
        return found

    def of_cells(self) -> Array:
        """Numbers of the local cells, ghosts included, shape (cells, expressions). Collective."""
        self._form.assemble(self._vector)
        self._vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        with self._vector.localForm() as local:
            found: Array = local.array_r.reshape(-1, self._n)[self._dofs[:, 0]]
        return found


class CentreValues:
    """Values of scalar expressions at the centre of each cell. Collective."""

    def __init__(self, mesh: Any, *expressions: Any) -> None:
        data = {
            "quadrature_degree": 1,
            "quadrature_rule": "custom",
            "quadrature_points": CENTRE[_compat.cell_name(mesh)],
            "quadrature_weights": [1.0],
        }
        volume = abs(ufl.JacobianDeterminant(mesh))
        at_centre = ufl.dx(domain=mesh, metadata=data)
        self._numbers = CellNumbers(mesh, ([e / volume for e in expressions], at_centre))

    def in_cells(self) -> Array:
        """Values in the local cells, ghosts included, shape (cells, expressions). Collective."""
        return self._numbers.of_cells()
