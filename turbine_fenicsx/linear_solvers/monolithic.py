"""Sparse LU of the whole tangent: slow, simple, the reference to check against."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.linear_solvers.base import DirectSolver
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.factor import SparseFactor


class MonolithicLU(DirectSolver):
    """LU of the nested tangent converted to one sparse matrix.

    Args:
        step: The step whose tangent is solved with.
    """

    def __init__(self, step: StepBlocks, prefix: str) -> None:
        """Remember the step; the matrix is made by the first update."""
        self._step, self._prefix = step, prefix
        self._factor: SparseFactor | None = None

    def update(self, x: PETSc.Vec) -> None:
        """Assemble, convert and factorise."""
        self._step.tangent(x)
        self.destroy()
        self._matrix = self._step.tangent_matrix.convert("aij", PETSc.Mat())
        self._factor = SparseFactor(self._matrix, f"{self._prefix}monolithic_")
        self._factor.update()
        self._b, self._x = self._matrix.createVecs()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side."""
        assert self._factor is not None
        self.krylov_iterations += 1
        parts = [v.array_r for v in b.getNestSubVecs()]
        self._b.array[:] = np.concatenate(parts)
        self._factor.solve(self._b, self._x)
        ends = np.cumsum([p.size for p in parts])
        for part, y in zip(x.getNestSubVecs(), np.split(self._x.array_r, ends[:-1]), strict=True):
            part.array[:] = y

    def destroy(self) -> None:
        """Free all PETSc objects."""
        if self._factor is not None:
            self._factor.destroy()
            for thing in (self._matrix, self._b, self._x):
                thing.destroy()
            self._factor = None
