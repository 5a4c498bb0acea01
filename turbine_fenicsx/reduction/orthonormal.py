"""Functions that are orthogonal to each other in the mass of a body."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy import sparse

from turbine_fenicsx.foundation.types import Array


class Orthonormal:
    """Functions that are orthogonal to each other in the mass, with the mass of the body.

    Args:
        mass: int rho N_a N_b dV, shape (N, N) [kg].
        apart: Functions that others must be orthogonal to, shape (N, k).
    """

    def __init__(self, mass: sparse.csr_matrix, apart: Array) -> None:
        self._mass, self._scale = mass, float(np.sqrt(mass.sum()))
        self._all: list[Array] = []
        self._apart = 0
        for f in apart.T:
            self._append(f, 0.0)
        self._apart = len(self._all)

    def __len__(self) -> int:
        """Number of functions."""
        return len(self._all) - self._apart

    @property
    def functions(self) -> Array:
        """The functions, shape (N, k)."""
        rows = self._all[self._apart :]
        return self._scale * np.array(rows).T.reshape(self._mass.shape[0], len(rows))

    def coordinates(self, fields: Array) -> Array:
        """Vectors a_k of the nearest fields sum_k psi_k a_k, shape (..., k, 3).

        Args:
            fields: Shape (..., N, 3).
        """
        weighted = self._mass @ self.functions / self._scale**2
        found: Array = weighted.T @ fields
        return found

    def add(self, fields: Iterable[Array], negligible: float, most: int) -> None:
        """Add the components of fields as far as they are new, until there are enough.

        Args:
            fields: Shape (N, k) each, with any number of components.
            negligible: Part of a field that counts as zero, in the norm of the mass.
            most: Number of functions that is enough.
        """
        for field in fields:
            size = float(np.sqrt(np.sum(field * (self._mass @ field))))
            for component in field.T:
                if len(self) < most:
                    self._append(component, negligible * size)

    def _append(self, f: Array, least: float) -> None:
        """Append a function if what is new of it is not negligible."""
        for _ in range(2):  # twice is enough
            for known in self._all:
                f = f - (known @ (self._mass @ f)) * known
        norm = float(np.sqrt(f @ (self._mass @ f)))
        if norm > least:
            self._all.append(f / norm)
