"""Rotations and spins of sections from sums over their nodes, see `section_transfer`.

With B_j = H_j x, the rotation A nearest to B, and J = tr(A^T B) 1 - B A^T,

    omega = J^-1 sum_j A_j x H_j x',        H_j takes the forces (J^-1 M) x A_j.

Frames of three arms r_j have r_j in place of A_j, and J = sum_j (|r_j|^2 1 - r_j r_j^T).

`compile_section_turns` makes the same of C code, in a tenth of the time.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.c_code import CompiledCode
from turbine_fenicsx.foundation.rotations import cross_rows, nearest_rotation
from turbine_fenicsx.foundation.types import Array

DECLARATION = """
void find_turns(int, const double *, double *, double *, double *);
void find_spins(int, const double *, double *, double *);
void find_rows(int, const double *, const double *, const double *, const double *, double *);
"""


class SectionTurns(Protocol):
    """Rotations and spins of sections from the sums of their nodes."""

    def find(self, sums: Array) -> tuple[Array, Array, Array]:
        """A, J^-1 and omega of n sections, shapes (n, 3, 3), (n, 3, 3) and (n, 3).

        Args:
            sums: H_j x and H_j x', shape (n, 4, 6).
        """

    def find_spins(self, sums: Array) -> tuple[Array, Array]:
        """J^-1 and omega of n frames, shapes (n, 3, 3) and (n, 3).

        Args:
            sums: r_j and r_j' in the last three rows of each, shape (n, 4, 6).
        """

    def find_rows(self, F: Array, M: Array, A: Array, inverse: Array) -> Array:
        """Forces that the rows H_j take for loads F and M of shape (n, 3), shape (n, 4, 3)."""


class NumpyTurns:
    """`SectionTurns` of NumPy."""

    def find(self, sums: Array) -> tuple[Array, Array, Array]:
        """As of `SectionTurns`."""
        B, rates = sums[:, 1:, :3].swapaxes(1, 2), sums[:, 1:, 3:]
        A = nearest_rotation(B)
        return A, *_find_spins(B, A, rates)

    def find_spins(self, sums: Array) -> tuple[Array, Array]:
        """As of `SectionTurns`."""
        arms, rates = sums[:, 1:, :3].swapaxes(1, 2), sums[:, 1:, 3:]
        return _find_spins(arms, arms, rates)

    def find_rows(self, F: Array, M: Array, A: Array, inverse: Array) -> Array:
        """As of `SectionTurns`."""
        turn, on_rows = (inverse @ M[:, :, None])[:, :, 0], np.empty((len(F), 4, 3))
        on_rows[:, 0] = F
        for j in range(3):
            on_rows[:, 1 + j] = cross_rows(turn, A[:, :, j])
        return on_rows


class CompiledTurns(CompiledCode):
    """`SectionTurns` of C code."""

    def find(self, sums: Array) -> tuple[Array, Array, Array]:
        """As of `SectionTurns`."""
        n = len(sums)
        found = np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3))
        self._lib.find_turns(n, self._address(sums), *map(self._address, found))
        return found

    def find_spins(self, sums: Array) -> tuple[Array, Array]:
        """As of `SectionTurns`."""
        found = np.empty((len(sums), 3, 3)), np.empty((len(sums), 3))
        self._lib.find_spins(len(sums), self._address(sums), *map(self._address, found))
        return found

    def find_rows(self, F: Array, M: Array, A: Array, inverse: Array) -> Array:
        """As of `SectionTurns`."""
        on_rows = np.empty((len(F), 4, 3))
        self._lib.find_rows(len(F), *map(self._address, (F, M, A, inverse, on_rows)))
        return on_rows


def compile_section_turns(comm: MPI.Intracomm) -> SectionTurns:
    """Compiled turns; those of NumPy where there is no compiler. Collective."""
    module = _compat.load_c(comm, Path(__file__).with_suffix(".c"), DECLARATION)
    return NumpyTurns() if module is None else CompiledTurns(module)


def _find_spins(B: Array, A: Array, rates: Array) -> tuple[Array, Array]:
    """J^-1 and omega for J = tr(A^T B) 1 - B A^T, of columns A_j and B_j, and rows of rates."""
    J = np.einsum("nij,nij->n", A, B)[:, None, None] * np.eye(3) - B @ A.swapaxes(1, 2)
    inverse, D = np.linalg.inv(J), A @ rates
    moments = np.stack([D[:, i, j] - D[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    return inverse, (inverse @ moments[:, :, None])[:, :, 0]
