"""Parts of matrices of nodal vectors that couple some directions in space only."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np
import numpy.typing as npt


def keep_directions(full: PETSc.Mat, kept: npt.NDArray[np.bool_]) -> PETSc.Mat:
    """The entries of a matrix that couple some directions, as a matrix without the others.

    Args:
        kept: Whether the entries between two directions stay, shape (3, 3).
    """
    starts, columns, values = full.getValuesCSR()
    rows = np.repeat(np.arange(starts.size - 1), np.diff(starts))
    stay = kept[rows % 3, columns % 3]
    lengths = np.bincount(rows[stay], minlength=starts.size - 1)
    starts = np.concatenate([[0], np.cumsum(lengths)]).astype(PETSc.IntType)
    csr = (starts, columns[stay], values[stay])
    matrix = PETSc.Mat().createAIJ(full.getSizes(), csr=csr, comm=full.getComm())
    matrix.assemble()
    return matrix
