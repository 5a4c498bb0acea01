"""Sums over the ranks that several channels need, in one collective call per step."""

from __future__ import annotations

from collections.abc import Callable

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.snapshot import Snapshot


class SharedSum:
    """Adds up arrays over the ranks, once per snapshot however many ask for it.

    Args:
        comm: Communicator.
    """

    def __init__(self, comm: MPI.Intracomm) -> None:
        self._comm = comm
        self._parts: list[Callable[[Snapshot], Array]] = []
        self._snapshot: Snapshot | None = None
        self._sums: list[Array] = []

    def add(self, part: Callable[[Snapshot], Array]) -> Callable[[Snapshot], Array]:
        """Add something to be summed.

        Args:
            part: This rank's part, of the same shape on all ranks; called once per snapshot.

        Returns:
            Function that gives the sum over all ranks. Collective the first time that any sum of
            a snapshot is asked for.
        """
        index = len(self._parts)
        self._parts.append(part)
        return lambda snapshot: self._at(snapshot)[index]

    def _at(self, snapshot: Snapshot) -> list[Array]:
        """All sums of a snapshot."""
        if snapshot is not self._snapshot:
            parts = [part(snapshot) for part in self._parts]
            local = np.concatenate([part.ravel() for part in parts])
            total = sum_over_ranks(self._comm, local)
            ends = np.cumsum([part.size for part in parts])
            self._sums = [
                total[end - part.size : end].reshape(part.shape)
                for part, end in zip(parts, ends, strict=True)
            ]
            self._snapshot = snapshot
        return self._sums
