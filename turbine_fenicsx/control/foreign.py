"""Controllers of others: whatever they do ends in a sentence, and a run with them can resume.

They run on rank 0 alone. A checkpoint holds the state before the last one that such a controller
has saved, if it saves any, and all its input and commands since. On restart that state is restored
and the input replayed. If the commands then differ from the recorded ones, it depends on something
unsaved, and the run ends with a sentence.
"""

from __future__ import annotations

import logging
import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, runtime_checkable

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.control.command_check import check_commands
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.foundation.errors import ForeignError, InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

BLOCK = 10_000
"""Calls that are packed together."""


class CallHistory:
    """Rows of calls. Full blocks are packed, a tenth of a kilobyte for each call.

    Attributes:
        count: Number of rows.
    """

    def __init__(self) -> None:
        self.count = 0
        self._packed = bytearray()
        self._rest = array("d")
        self._width = 0

    def append(self, row: Sequence[float]) -> None:
        """Append a row; all have the same length."""
        self.count += 1
        self._width = len(row)
        self._rest.extend(row)
        if len(self._rest) >= BLOCK * self._width:
            self._packed += _pack(self._rest, self._width)
            self._rest = array("d")

    def pack(self) -> bytes:
        """All rows."""
        return bytes(self._packed) + (_pack(self._rest, self._width) if self._rest else b"")


def _pack(rows: array[float], width: int) -> bytes:
    """Pack rows by columns, as whole columns may hold one number."""
    return zlib.compress(np.array(rows).reshape(-1, width).T.tobytes(), level=1)


def unpack(packed: bytes, width: int) -> Iterator[Array]:
    """The rows of histories that were packed, one after another, each of shape (width,)."""
    while packed:
        stream = zlib.decompressobj()
        columns = np.frombuffer(stream.decompress(packed)).reshape(width or 1, -1)
        yield from columns.T
        packed = stream.unused_data


log = logging.getLogger(__name__)

LAYOUT = 2
"""Of what a checkpoint holds; 1 was a table of what the controller had seen."""

WINDOW = 10_000
"""Calls after which a controller is asked for its state, also where no checkpoint is due."""

COMMAND_TOLERANCE = 1e-6
"""Commands that differ by less than this share are the same, rounded on another computer."""

COMMANDED = ("generator torque", *(f"pitch of blade {k}" for k in (1, 2, 3)), "yaw rate", "brake")


class Responder(Protocol):
    """Interface of an external controller on rank 0."""

    def respond(self, measured: Measurements) -> Commands:
        """Commands for the next step; raises ForeignError if there are none."""

    def finish(self) -> None:
        """The run has ended; raises ForeignError if something of it fails."""


@runtime_checkable
class RestartableResponder(Responder, Protocol):
    """One that may be able to save its own state."""

    def save(self) -> RestartData:
        """Its state, of rank 0; nothing if it cannot. Raises ForeignError if that fails."""

    def restore(self, data: RestartData) -> None:
        """Restore that state. Raises ForeignError if that fails."""


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
        # the last two saved states, each with the calls since then; empty on other ranks
        self._windows = [(RestartData(), CallHistory())]
        self._width = 0
        self._saves = True

        def keep() -> None:
            self._responder = make()

        on_rank0(comm, keep)

    def command(self, measured: Measurements) -> Commands:
        """Its answer, on rank 0. Collective.

        Raises:
            ForeignError: if it fails, on all ranks.
        """
        return on_rank0(self._comm, lambda: self._respond(measured))

    def _respond(self, measured: Measurements) -> Commands:
        """Its answer, checked and kept; on rank 0."""
        assert self._responder is not None
        commands = check_commands(self._responder.respond(measured), self._who, measured.time)
        row = measured.to_row() + commands.to_row()
        self._width = len(row)
        calls = self._windows[-1][1]
        calls.append(row)
        if calls.count >= WINDOW:
            self._keep_state()
        return commands

    def _keep_state(self) -> None:
        """Let it save its state in place of all earlier calls, if it can; on rank 0."""
        if not self._saves or not isinstance(self._responder, RestartableResponder):
            return
        try:
            state = self._responder.save()
        except ForeignError:
            self._saves = False  # the last state and the calls since then are as good
            raise
        self._saves = bool(state)
        if state:
            self._windows = [self._windows[-1], (state, CallHistory())]

    def save(self) -> RestartData:
        """The state before its last saved one, and its calls since then. Collective; of rank 0.

        They show on restart whether what it saves is all that it needs.
        """
        on_rank0(self._comm, self._keep_state)
        data = RestartData({"layout": LAYOUT, "width": self._width})
        data.add("state", self._windows[0][0])
        packed = b"".join(calls.pack() for _, calls in self._windows)
        data.arrays["calls"] = np.frombuffer(packed, np.uint8)
        return data

    def restore(self, data: RestartData) -> None:
        """Restore its state and replay its input since then. Collective.

        Raises:
            InputError: for data of another layout.
            ForeignError: if it fails, or commands something else than it did.
        """
        found = data.numbers.get("layout", 1)
        if found != LAYOUT:
            raise InputError(
                f"cannot resume: the checkpoint holds data of {self._who} in layout {found}, and "
                f"this version reads layout {LAYOUT}; resume with the version that wrote it"
            )

        def replay() -> None:
            state = data.part("state")
            self._windows = [(state, CallHistory())]
            if state:
                assert isinstance(self._responder, RestartableResponder)
                self._responder.restore(state)
            packed, width = data.arrays["calls"], data.numbers["width"]
            for row in unpack(packed.tobytes(), width):
                self._show_again(row)

        on_rank0(self._comm, replay)

    def _show_again(self, row: Array) -> None:
        """Replay its input and compare its commands."""
        n = len(COMMANDED)
        measured = Measurements.from_row(row[:-n])
        new = self._respond(measured).to_row()
        for what, a, b in zip(COMMANDED, new, row[-n:].tolist(), strict=True):
            if abs(a - b) > COMMAND_TOLERANCE * max(abs(a), abs(b), COMMAND_TOLERANCE):
                raise ForeignError(
                    f"cannot resume: {self._who} does not do the same again. Shown what it saw at "
                    f"t = {measured.time:g} s, it commands {a:.9g} as {what} and not {b:.9g}: it "
                    "depends on chance, a clock or a file, or on something that save() leaves out"
                )

    def finish(self) -> None:
        """Call it at the end of the run; a failure is a warning. Collective."""

        def end() -> None:
            if self._responder is None:
                return
            try:
                self._responder.finish()
            except ForeignError as error:
                log.warning("%s", error)

        on_rank0(self._comm, end)
