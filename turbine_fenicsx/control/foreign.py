"""Controllers of others, whose memory cannot be looked into.

They run on rank 0 alone. After a restart such a controller is shown again all that it has seen, so
that it comes to be in the state in which it was; it must do the same whenever it sees the same.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.control.interface import Commands, Measurements, check_commands
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData


class Responder(Protocol):
    """What somebody else's controller is on rank 0."""

    def respond(self, measured: Measurements) -> Commands:
        """Commands for the next step; raises InputError if there are none."""

    def finish(self) -> None:
        """The run has ended."""


class ForeignController:
    """A `Controller` made of what runs on rank 0.

    Args:
        comm: Communicator.
        make: Makes it; called on rank 0.
        who: What it is called in errors.

    Raises:
        InputError: if it cannot be made, on all ranks.

    Note:
        Collective.
    """

    def __init__(self, comm: MPI.Intracomm, make: Callable[[], Responder], who: str) -> None:
        self._comm, self._who = comm, who
        self._responder: Responder | None = None
        self._seen: list[list[float]] = []

        def keep() -> None:
            self._responder = make()

        on_rank0(comm, keep)

    def command(self, measured: Measurements) -> Commands:
        """What it answers on rank 0. Collective."""
        self._seen.append(measured.to_row())
        return on_rank0(self._comm, lambda: self._respond(measured))

    def _respond(self, measured: Measurements) -> Commands:
        """What it answers, checked; on rank 0."""
        assert self._responder is not None
        return check_commands(self._responder.respond(measured), self._who, measured.time)

    def save(self) -> RestartData:
        """All that it has seen."""
        return RestartData(arrays={"seen": np.array(self._seen)})

    def restore(self, data: RestartData) -> None:
        """Show it all again. Collective."""
        rows = data.arrays["seen"]

        def show() -> None:
            for row in rows:
                self._respond(Measurements.from_row(row))

        self._seen = rows.tolist()
        on_rank0(self._comm, show)

    def finish(self) -> None:
        """Tell it that the run has ended. Collective."""

        def end() -> None:
            if self._responder is not None:
                self._responder.finish()

        on_rank0(self._comm, end)
