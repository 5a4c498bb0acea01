"""A symmetric matrix of 3 x 3 blocks, stored as its upper triangle: half to keep and to read."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.types import Array


def take_upper_triangle(matrix: PETSc.Mat) -> PETSc.Mat:
    """A symmetric positive definite matrix, stored as the upper triangle of its blocks. Collective.

    PETSc's own conversion takes a time that grows with the square of the size.

    Args:
        matrix: All rows and columns of a node next to each other, with the same entries in each of
            the three rows: all three directions of a node are free or none.
    """
    csr = _take_blocks(matrix, diagonal=False)
    found = PETSc.Mat().createSBAIJ(matrix.getSizes(), 3, csr=csr, comm=matrix.getComm())
    found.assemble()
    found.setOption(PETSc.Mat.Option.SPD, True)
    return found


def take_diagonal(matrix: PETSc.Mat) -> PETSc.Mat:
    """The diagonal blocks of such a matrix. Collective."""
    csr = _take_blocks(matrix, diagonal=True)
    found = PETSc.Mat().createBAIJ(matrix.getSizes(), 3, csr=csr, comm=matrix.getComm())
    found.assemble()
    return found


def _take_blocks(matrix: PETSc.Mat, diagonal: bool) -> tuple[Array, ...]:
    """Blocks of this rank's rows on the diagonal, or there and beyond, in compressed rows."""
    starts, columns, values = matrix.getValuesCSR()
    lengths = np.diff(starts)[::3].astype(np.int64)  # entries of each of the three rows of a node
    row = np.repeat(np.arange(lengths.size), lengths // 3)
    before = np.cumsum(lengths) - lengths
    place = 3 * (np.arange(row.size) - before[row] // 3) + starts[:-1:3].astype(np.int64)[row]
    column, this = columns[place] // 3, row + matrix.getOwnershipRange()[0] // 3
    chosen = column == this if diagonal else column >= this
    row, column, place = row[chosen], column[chosen], place[chosen]
    blocks = np.empty((row.size, 3, 3))
    for i in range(3):
        blocks[:, i] = values[(place + i * lengths[row])[:, None] + np.arange(3)]
    ends = np.cumsum(np.bincount(row, minlength=lengths.size))
    block_starts = np.concatenate([[0], ends]).astype(PETSc.IntType)
    return block_starts, column.astype(PETSc.IntType), blocks.ravel()
